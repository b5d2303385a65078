"""Several machines deliver one point to one server: however their requests interleave, one complete run remains."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from threading import Semaphore, Thread
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rl_design_space.tracking import client_writer
from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.client_runs import ClientRuns
from rl_design_space.tracking.client_writer import ClientWriter
from rl_design_space.tracking.content import RunContent
from rl_design_space.tracking.locks import locks_at
from rl_design_space.tracking.point_runs import PointRuns
from rl_design_space.tracking.spool import Record, Spool
from rl_design_space.tracking.store_errors import StoreUnavailableError
from tests.tracking.stores import import_mlflow

#: Seconds that a thread gets for a step of a few microseconds.
PATIENCE = 20
MACHINES = 3


class KilledError(BaseException):
    """Ends a writer as a killed process would."""


class Server:
    """A tracking server that knows as much as the delivery of points needs; requests take effect one by one."""

    def __init__(self) -> None:
        self.runs: dict[str, SimpleNamespace] = {}

    def statuses(self) -> list[str]:
        return sorted(run.info.status for run in self.runs.values())


class Client:
    """MLflow's client on one machine, which waits for its turn before each request that other machines can notice."""

    def __init__(self, server: Server, clock: int, turn: Callable[[], None]) -> None:
        self._server, self._clock, self._turn = server, clock, turn

    def get_experiment_by_name(self, name: str) -> SimpleNamespace:
        return SimpleNamespace(experiment_id=name, lifecycle_stage="active")

    def search_runs(self, experiments: Sequence[str], filter_: str) -> list[SimpleNamespace]:
        self._turn()
        assert filter_ == "tags.`fingerprint` = 'point'"
        # Copies: what another machine writes later is not seen.
        return [
            SimpleNamespace(info=SimpleNamespace(**vars(run.info)), data=SimpleNamespace(tags=dict(run.data.tags)))
            for run in reversed(self._server.runs.values())
        ]

    def create_run(self, experiment: str, *, tags: Mapping[str, str], **others: Any) -> SimpleNamespace:
        self._turn()
        run_id = f"run {len(self._server.runs)}"
        info = SimpleNamespace(run_id=run_id, status="RUNNING", end_time=None)
        self._server.runs[run_id] = SimpleNamespace(info=info, data=SimpleNamespace(tags=dict(tags)))
        return self._server.runs[run_id]

    def log_batch(self, run_id: str, *, tags: Sequence[Any] = (), **others: Any) -> None:
        if tags:
            self._turn()
            self._server.runs[run_id].data.tags.update({tag.key: tag.value for tag in tags})

    def set_tag(self, run_id: str, name: str, value: str) -> None:
        self._turn()
        self._server.runs[run_id].data.tags[name] = value

    def set_terminated(self, run_id: str, status: str, ended: int | None = None) -> None:
        self._turn()
        info = self._server.runs[run_id].info
        info.status, info.end_time = status, self._clock if ended is None else ended


class Machine:
    """A machine with a pending record of the point, which it delivers until it has succeeded."""

    def __init__(self, server: Server, folder: Path, number: int, clock: int) -> None:
        self._server, self._clock, self._number = server, clock, number
        # MLflow's client is the same for servers and for databases of an unknown schema.
        address = StoreAddress("postgresql://server/mlflow", "points", "sweeps")
        self._spool = Spool.of(folder / str(number), address)
        self._locks = locks_at(folder / f"{number}.claims")
        content = {"name": "", "started": 0, "tags": {f"study.{number}": "true"}, "params": {}, "checked": number > 0}
        content["ended"] = clock
        self._record = Record("point", "point", content)
        self._next, self._arrived = Semaphore(0), Semaphore(0)
        self._is_killed = False
        self.is_done = False
        self._start()

    def step(self) -> None:
        """Let one request through."""
        if not self.is_done:
            self._next.release()
            assert self._arrived.acquire(timeout=PATIENCE)

    def kill(self) -> None:
        """Kill the writer before its next request; another one continues."""
        if not self.is_done:
            self._is_killed = True
            self.step()
            self._is_killed = False
            self._start()

    def finish(self) -> None:
        while not self.is_done:
            self.step()

    def _start(self) -> None:
        self._thread = Thread(target=self._deliver, daemon=True)
        self._thread.start()
        assert self._arrived.acquire(timeout=PATIENCE)

    def _turn(self) -> None:
        self._arrived.release()
        assert self._next.acquire(timeout=PATIENCE)
        if self._is_killed:
            raise KilledError

    def _deliver(self) -> None:
        writer = ClientWriter(Client(self._server, self._clock, self._turn), self._spool, self._locks)
        try:
            writer.write([self._record])
            self.is_done = True
            # Only the first writer of a machine believes that the server does not have the point.
        except KilledError:
            self._record.content["checked"] = False
        self._arrived.release()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder for the machines; results have no content there."""
    import_mlflow()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(client_writer, "content_of", lambda record, run_id: RunContent([], {}, ""))
        yield tmp_path_factory.mktemp("machines")


ONE, OTHER = [(0, "step")], [(1, "step")]


@settings(max_examples=100, deadline=None)
@given(
    schedule=st.lists(st.tuples(st.integers(0, MACHINES - 1), st.sampled_from(["step", "step", "step", "kill"]))),
    clocks=st.lists(st.integers(-1, 1), min_size=MACHINES, max_size=MACHINES),
)
# Both find nothing, both write a run, one looks before the other is complete.
@example(schedule=2 * ONE + 2 * OTHER + 2 * ONE + 2 * OTHER, clocks=[0, 0, 0])
# A run that was begun continues after another machine has recorded the point.
@example(schedule=[*2 * ONE, (0, "kill"), *4 * OTHER], clocks=[0, 0, 0])
# The clock of the second one is behind.
@example(schedule=4 * OTHER + 4 * ONE, clocks=[-1, 1, 0])
def test_one_complete_run_remains(folder: Path, schedule: list[tuple[int, str]], clocks: list[int]):
    server = Server()
    machines = [Machine(server, folder, number, 100 * clock) for number, clock in enumerate(clocks)]
    was_recorded = False
    for number, what in schedule:
        getattr(machines[number], what)()
        is_recorded = "FINISHED" in server.statuses()
        assert is_recorded or not was_recorded, "a point was recorded, and is not any more"
        was_recorded = is_recorded
    for machine in machines:
        machine.finish()
    complete = [run for run in server.runs.values() if run.info.status == "FINISHED"]
    assert server.statuses() == ["FINISHED", *["KILLED"] * (len(server.runs) - 1)]
    assert {f"study.{number}" for number in range(MACHINES)} <= complete[0].data.tags.keys()
    for run in server.runs.values():
        is_marked = run.data.tags.get("rl_design_space.incomplete", "").startswith("its point is recorded by run ")
        assert is_marked == (run is not complete[0])


def test_a_store_that_keeps_nothing_does_not_occupy_delivery_for_ever(folder: Path):
    server = Server()
    client = Client(server, 0, lambda: None)
    for _ in range(2):
        client.set_terminated(client.create_run("points", tags={}).info.run_id, "FINISHED")
    client.set_terminated = lambda *ending: None
    with pytest.raises(StoreUnavailableError, match="run 0: what the store has accepted is not there"):
        PointRuns(ClientRuns(client, "uri"), "points", ()).settle("point", {})
