"""Textbook C (textbook.c), compiled with gcc for this machine and called through ctypes."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from benchmarks.job import Job
from benchmarks.peers import Learn, Missing

TITLE = "C, textbook"
PERIODS = 500

_SOURCE = Path(__file__).with_name("textbook.c")
_FLAGS = ("-O3", "-march=native")
_COMPILER = shutil.which("gcc") or ""
if not _COMPILER:
    raise Missing("the C compiler gcc is not installed")


class _Job(ctypes.Structure):
    """The struct at the head of choosing.h."""

    _fields_ = (
        *((name, ctypes.c_int) for name in ("cells", "goals", "trials", "max_steps")),
        *((name, ctypes.c_double) for name in ("alpha", "gamma")),
        *((name, ctypes.c_double) for name in ("step_reward", "sub_goal_reward", "final_goal_reward")),
    )


def version() -> str:
    """The tool that learns."""
    first_line = subprocess.run([_COMPILER, "--version"], capture_output=True, text=True, check=True, timeout=60).stdout
    return " ".join((first_line.splitlines()[0], *_FLAGS))


def _library() -> ctypes.CDLL:
    with TemporaryDirectory() as folder:
        target = Path(folder) / "textbook.so"
        subprocess.run([_COMPILER, *_FLAGS, "-shared", "-fPIC", "-o", target, _SOURCE], check=True, timeout=60)
        return ctypes.CDLL(str(target))


def prepare(job: Job) -> Learn:
    """Get ready for a job."""
    library = _library()
    fields = {**asdict(job), "cells": job.cells}
    struct = _Job(**{name: fields[name] for name, *_ in _Job._fields_})
    next_cell, epsilon = job.next_cell(), job.epsilon()
    q = np.empty((job.states, 4))

    def learn(layouts: NDArray[np.int32], seed: int) -> NDArray[np.int64]:
        total = np.empty(len(layouts), dtype=np.int64)
        layouts = np.ascontiguousarray(layouts)
        library.learn(
            ctypes.byref(struct), _pointer(next_cell), _pointer(epsilon), _pointer(layouts), len(layouts),
            ctypes.c_uint64(seed), _pointer(q), _pointer(total),
        )  # fmt: skip
        return total

    return learn


def _pointer(array: NDArray[np.generic]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
