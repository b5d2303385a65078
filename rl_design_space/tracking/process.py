"""The tracker process: it delivers a spool while the process that started it lives."""

from __future__ import annotations

import json
import os
import signal
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event, Thread

from filelock import Timeout

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.delivery import Delivery
from rl_design_space.tracking.spool import Spool
from rl_design_space.tracking.tracker_process import BACKGROUND, FOREGROUND

#: MLflow asks these modules before each request whether it runs in a notebook, and Python looks for them each time: a
#: quarter of the CPU time of a point.
_NOTEBOOKS = ("IPython", "dbruntime", "pyspark")
#: Niceness in the background: the lowest priority there is. Where all cores learn, it leaves the tracker process idle
#: time and a seventieth of one core.
_NICENESS = 19


def main() -> None:
    """Deliver the spool that the command line names, until standard input ends.

    The second argument is the priority, `foreground` or `background`; a line of standard input with either word changes
    it. Messages go to standard output, a line of JSON each: `{"problem": "…"}` says what is wrong with the store, with
    null when it is open and nothing is wrong; `{"unusable": "…"}` says why the process gives up.
    """
    # Signals are meant for the process that started this one, which ends it by closing its input.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    forget_notebooks()
    ended, foreground = Event(), Event()
    if sys.argv[2] == FOREGROUND:
        foreground.set()
    Thread(target=_watch_input, args=(ended, foreground), daemon=True).start()
    Thread(target=_watch_parent, args=(ended,), daemon=True).start()
    spool = Spool(Path(sys.argv[1]))
    while not ended.is_set():
        try:
            # One process delivers for all. Waiting for it costs nothing, because nothing is imported yet.
            with spool.lock.acquire(timeout=1):
                _deliver(Delivery(spool, lambda problem: _send(problem=problem), ended), ended, foreground)
        except Timeout:
            continue
        except ConfigError as error:
            _send(unusable=str(error))
            return


def forget_notebooks() -> None:
    """Make the modules of notebooks impossible to import: this process is no notebook."""
    for name in _NOTEBOOKS:
        sys.modules[name] = None  # type: ignore[assignment]


def _deliver(delivery: Delivery, ended: Event, foreground: Event) -> None:
    """Deliver in one of two threads: a priority that was lowered cannot be raised again."""
    with ThreadPoolExecutor(1, initializer=_lower_priority) as background:
        while not ended.is_set():
            background.submit(delivery.run_while, lambda: not foreground.is_set()).result()
            delivery.run_while(foreground.is_set)
    delivery.deliver_summaries()


def _lower_priority() -> None:
    if sys.platform == "linux":  # elsewhere, niceness is a property of the whole process
        os.nice(_NICENESS)


def _watch_input(ended: Event, foreground: Event) -> None:
    for line in sys.stdin:
        if line.strip() == FOREGROUND:
            foreground.set()
        elif line.strip() == BACKGROUND:
            foreground.clear()
    ended.set()


def _watch_parent(ended: Event) -> None:
    """End when the parent process does: the input may stay open, because other processes can have inherited it."""
    parent = os.getppid()
    while not ended.wait(1):
        if os.getppid() != parent:
            ended.set()


def _send(**message: str | None) -> None:
    try:
        print(json.dumps(message), flush=True)
    except BrokenPipeError:
        # The parent has ended; what is left to do is in the spool. The descriptor must stay in use: SQLite would get a
        # free one for the database and close it again, being a standard one, and the process would lose all its locks.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    main()
    # Everything is on disk, in the store, or sent. Python would spend half a second on unloading MLflow's modules.
    os._exit(0)
