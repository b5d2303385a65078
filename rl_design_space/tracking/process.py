"""The tracker process: it delivers a spool while the process that started it lives, and lets others learn first."""

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
from rl_design_space.tracking.pace import CALM, HURRY
from rl_design_space.tracking.spool import Spool
from rl_design_space.tracking.writer import Writer

#: How much lower the priority is while others learn: as low as it gets. Where all cores learn, what is left over, and
#: a seventieth of one core, has to do.
_NICENESS = 19


def main() -> None:
    """Deliver the spool that is named on the command line until standard input ends.

    The pace follows, `HURRY` or `CALM`; lines of the input say when it changes. What is told goes to standard output, a
    line of JSON each: `{"trouble": "…"}`, or null when the store is open and all is well, and `{"unusable": "…"}`
    before giving up.
    """
    # Signals are meant for the process that started this one, which ends it by closing its input.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    ended, hurried = Event(), Event()
    if sys.argv[2] == HURRY:
        hurried.set()
    Thread(target=_watch_input, args=(ended, hurried), daemon=True).start()
    Thread(target=_watch_parent, args=(ended,), daemon=True).start()
    spool = Spool(Path(sys.argv[1]))
    while not ended.is_set():
        try:
            # Whoever delivers now delivers for all; to wait for it costs nothing, for nothing is imported yet.
            with spool.lock.acquire(timeout=1):
                _deliver(Writer(spool, lambda trouble: _say(trouble=trouble), ended), ended, hurried)
        except Timeout:
            continue
        except ConfigError as error:
            _say(unusable=str(error))
            return


def _deliver(writer: Writer, ended: Event, hurried: Event) -> None:
    """Deliver at one priority or the other. One that was lowered cannot be raised, so two threads take turns."""
    with ThreadPoolExecutor(1, initializer=_lower_priority) as calm:
        while not ended.is_set():
            calm.submit(writer.run_until, hurried.is_set).result()
            writer.run_until(lambda: not hurried.is_set())
    writer.leave()


def _lower_priority() -> None:
    if sys.platform == "linux":  # elsewhere it is the priority of all threads
        os.nice(_NICENESS)


def _watch_input(ended: Event, hurried: Event) -> None:
    for line in sys.stdin:
        if line.strip() == HURRY:
            hurried.set()
        elif line.strip() == CALM:
            hurried.clear()
    ended.set()


def _watch_parent(ended: Event) -> None:
    """The input may outlive the process that started this one: others can have inherited its other end."""
    parent = os.getppid()
    while not ended.wait(1):
        if os.getppid() != parent:
            ended.set()


def _say(**message: str | None) -> None:
    try:
        print(json.dumps(message), flush=True)
    except BrokenPipeError:
        # Nobody listens any more; what is left to do is in the spool. The descriptor stays in use: SQLite would get a
        # free one for the database and close it again, being a standard one, by which the process loses all its locks.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    main()
    # All is on disk, in the store, or told. To take MLflow's modules apart takes half a second that somebody waits for.
    os._exit(0)
