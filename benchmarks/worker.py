"""One peer in its own process: reads requests from stdin and answers on stdout, a line of JSON each.

Requests are `{"prepare": job}`, once, and `{"learn": layouts, "seed": …}`; see `benchmarks.client` for the replies.
Only NumPy is imported besides the peer, so that what is measured is the peer's own.
"""

from __future__ import annotations

import json
import os
import resource
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from benchmarks.job import Job
from benchmarks.peers import Learn, Missing, load


def peak_mib() -> float:
    """The most memory that this process has held."""
    status = Path("/proc/self/status")
    if status.exists():
        # What getrusage says begins with the memory of the parent.
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) / 1024
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def main() -> None:
    """Serve one peer until stdin ends."""
    # Whatever a peer prints goes to stderr; stdout belongs to the replies.
    replies = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)

    def reply(**values: Any) -> None:
        print(json.dumps(values), file=replies, flush=True)

    try:
        peer = load(sys.argv[1])
    except Missing as missing:
        reply(missing=str(missing))
        return
    reply(title=peer.TITLE, version=peer.version(), periods=peer.PERIODS)

    learn: Learn | None = None
    for line in sys.stdin:
        request = json.loads(line)
        total: list[int] = []
        if learn is None:
            started = perf_counter()
            learn = peer.prepare(Job(**request["prepare"]))
            seconds = perf_counter() - started
        else:
            layouts = np.array(request["learn"], dtype=np.int32)
            started = perf_counter()
            learned = learn(layouts, request["seed"])
            seconds = perf_counter() - started
            total = learned.tolist()
        reply(seconds=seconds, total=total, peak_mib=peak_mib())


if __name__ == "__main__":
    main()
