"""From the command to the first result: wall time and peak memory of whole processes, beside their imports alone.

The import floor is a Python process that imports what the command has imported by its end, of other packages and
of the standard library, and nothing else; no change to this package could make it faster than that.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pandas as pd

from benchmarks.processes import run
from benchmarks.tables import number, spread

BARE, FLOOR, HELP, ONE, DEFAULT = (
    "python alone",
    "imports alone",
    "rl-design-space --help",
    "rl-design-space tracking=none task.periods=1",
    "rl-design-space tracking=none",
)

# Starts one command from a process of its own, because RUSAGE_CHILDREN is the maximum over all children, and that of
# a child begins with the memory of its parent: this one is small.
_LAUNCHER = """
import json, resource, subprocess, sys, time
started = time.perf_counter()
status = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL).returncode
seconds = time.perf_counter() - started
print(json.dumps([status, seconds, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss]))
"""

# Runs the command and lists what it has imported that is not of this package, in order.
_MODULES = """
import json, sys
from rl_design_space.commands.cli import main
target = sys.argv.pop(1)
main()
own = ("__main__", "rl_design_space", "hydra_plugins")
names = [name for name, module in sys.modules.items()
         if getattr(module, "__spec__", None) and name == module.__spec__.name and not name.startswith(own)]
open(target, "w").write(json.dumps(names))
"""

# Imports what a file lists. Names that only their package can import are left out the first time.
_IMPORT = """
import importlib, json, sys
kept = []
for name in json.load(open(sys.argv[1])):
    try:
        importlib.import_module(name)
        kept.append(name)
    except ImportError:
        pass
if len(sys.argv) > 2:
    json.dump(kept, open(sys.argv[2], "w"))
"""


def measure(rounds: int, report: Callable[[str], None] = print) -> pd.DataFrame:
    """Start every command in turn, learning with a warm compilation cache.

    Returns:
        One row a command and round: case, round, seconds, peak_mib.
    """
    with TemporaryDirectory() as folder:
        commands = _commands(Path(folder))
        rows: list[dict[str, Any]] = []
        for round_ in range(rounds):
            for case, command in commands.items():
                rows.append({"case": case, "round": round_, **_started(command)})
            report(f"start: round {round_ + 1} of {rounds}")
    return pd.DataFrame(rows)


def summary(calls: pd.DataFrame) -> pd.DataFrame:
    """Medians and quartiles of wall time, the median time beyond the imports within a round, and peak memory."""
    floor = calls[calls["case"] == FLOOR].set_index("round")["seconds"]
    # The imports are those of a command that learns.
    beyond = (calls["seconds"] - calls["round"].map(floor)).where(calls["case"].isin([ONE, DEFAULT]))
    grouped = calls.assign(beyond=beyond).groupby("case", sort=False)
    return pd.DataFrame(
        {
            "seconds": grouped["seconds"].median(),
            "seconds_q25": grouped["seconds"].quantile(0.25),
            "seconds_q75": grouped["seconds"].quantile(0.75),
            "beyond_imports": grouped["beyond"].median(),
            "peak_mib": grouped["peak_mib"].median(),
        }
    ).reset_index()


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """The table that people read."""
    rows = [
        {
            "command": row["case"],
            "wall s": spread(row, "seconds", "seconds_q25", "seconds_q75"),
            "s beyond the imports": number(row["beyond_imports"]),
            "peak MiB": number(row["peak_mib"]),
        }
        for row in frame.to_dict("records")
    ]
    return pd.DataFrame(rows)


def _commands(folder: Path) -> dict[str, list[str]]:
    """What to start by its name. Learning once to list the imports also leaves a warm compilation cache."""
    python = [sys.executable]
    options = ["tracking=none", f"outputs={folder}/outputs"]
    used, importable = str(folder / "used.json"), str(folder / "importable.json")
    run([*python, "-c", _MODULES, used, *options, "task.periods=1"])
    run([*python, "-c", _IMPORT, used, importable])
    application = [*python, "-m", "rl_design_space"]
    return {
        BARE: [*python, "-c", ""],
        FLOOR: [*python, "-c", _IMPORT, importable],
        HELP: [*application, "--help"],
        ONE: [*application, *options, "task.periods=1"],
        DEFAULT: [*application, *options],
    }


def _started(command: Sequence[str]) -> dict[str, float]:
    # Isolated and without site-packages, so that the launcher stays small.
    output = run([sys.executable, "-I", "-S", "-c", _LAUNCHER, *command]).stdout
    status, seconds, peak = json.loads(output)
    if status:
        raise RuntimeError(f"{command} ended with status {status}")
    return {"seconds": seconds, "peak_mib": peak / (2**20 if sys.platform == "darwin" else 2**10)}
