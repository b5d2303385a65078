"""One small race of all peers that are installed, and of some that should not get through."""

from __future__ import annotations

import pytest

from benchmarks.job import Job
from benchmarks.peers import OURS, PEERS
from benchmarks.race import Entrant, Setting, race
from benchmarks.race_table import calls_frame, frame_of, text_of, versions
from benchmarks.tables import page

HERE = f"{__package__}.peers"
MISSING, BROKEN, WRONG = f"{HERE}.missing", f"{HERE}.broken", f"{HERE}.exploring_among_all"
#: These need nothing but what the package needs, and a C compiler.
ALWAYS = {OURS, "textbook_c", "numba_plain", "numpy_batch"}

#: MushroomRL asks for an older NumPy than the package, so it never shares an environment with these tests.
TOGETHER = tuple(name for name in PEERS if name != "mushroom_rl_agent")

SETTING = Setting(
    job=Job(side=6, goals=2, trials=30),
    peers=(*TOGETHER, MISSING, BROKEN, WRONG),
    rounds=2,
    check_periods=40,
    periods=100,
    compiles=False,
)


@pytest.fixture(scope="module")
def entrants() -> dict[str, Entrant]:
    return {entrant.name: entrant for entrant in race(SETTING, report=lambda _: None)}


def installed(entrants: dict[str, Entrant], name: str) -> Entrant:
    entrant = entrants[name]
    if entrant.state == "missing" and name not in ALWAYS:
        pytest.skip(f"{name}: {entrant.note}")
    return entrant


@pytest.mark.parametrize("name", TOGETHER)
def test_a_peer_does_the_same_job_as_ours(entrants: dict[str, Entrant], name: str):
    entrant = installed(entrants, name)
    assert entrant.state == "ok", entrant.note
    assert entrant.agreement.periods >= SETTING.check_periods
    assert abs(entrant.agreement.t) < 4
    assert not entrant.void


@pytest.mark.parametrize("name", TOGETHER)
def test_a_peer_is_measured_in_every_round(entrants: dict[str, Entrant], name: str):
    entrant = installed(entrants, name)
    assert [call.round for call in entrant.calls] == [0, 1]
    assert all(call.seconds > 0 and call.steps > 0 for call in entrant.calls)
    assert entrant.start_seconds > 0
    assert entrant.compile_seconds >= 0
    assert entrant.peak_mib > 1
    assert entrant.version


def test_the_jax_peers_make_the_same_steps(entrants: dict[str, Entrant]):
    one, other = installed(entrants, "jax_map"), installed(entrants, "jax_batch")
    assert {seed: total.tolist() for seed, total in one.totals.items()} == {
        seed: total.tolist() for seed, total in other.totals.items()
    }


def test_a_missing_peer_is_skipped_by_name(entrants: dict[str, Entrant]):
    assert entrants[MISSING].state == "missing"
    assert "a_package_that_nobody_has" in entrants[MISSING].note
    assert "a_package_that_nobody_has" in versions(frame_of(list(entrants.values())))[MISSING]


def test_a_peer_that_fails_leaves_the_race_with_its_reason(entrants: dict[str, Entrant]):
    assert entrants[BROKEN].state == "failed"
    assert entrants[BROKEN].note == "ValueError: cannot learn on 36 cells"


def test_a_peer_with_another_job_is_void_and_not_timed(entrants: dict[str, Entrant]):
    assert entrants[WRONG].void
    assert entrants[WRONG].agreement.difference < -0.05
    assert entrants[WRONG].calls == []
    row = frame_of(list(entrants.values())).set_index("peer").loc[WRONG]
    assert row["state"] == "VOID"
    assert row[["ns_per_step", "ratio"]].isna().all()


def test_ratios_are_taken_within_a_round(entrants: dict[str, Entrant]):
    ours, c = entrants[OURS], entrants["textbook_c"]
    assert c.ratios(ours) == [theirs.ns / own.ns for theirs, own in zip(c.calls, ours.calls, strict=True)]
    assert ours.ratios(ours) == [1.0, 1.0]
    assert len(calls_frame([ours, c])) == 4


def test_the_markdown_table_is_well_formed(entrants: dict[str, Entrant]):
    frame = frame_of(list(entrants.values()))
    text = text_of(frame)
    lines = page("Race", text, versions(frame)).splitlines()
    table = [line for line in lines if line.startswith("|")]
    assert len(table) == 2 + len(entrants)
    assert {line.count("|") for line in table} == {len(text.columns) + 1}
    assert lines.index(table[-1]) - lines.index(table[0]) + 1 == len(table)
    assert [line.split("|")[2].strip() for line in table[-3:]] == ["missing", "failed", "VOID"]
