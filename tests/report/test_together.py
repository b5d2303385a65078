"""The files of a report get into place together, and those that an earlier one has left are named."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from rl_design_space.commands.left_files import tell_of_left
from rl_design_space.report import together as module
from rl_design_space.report.base import MAIN
from rl_design_space.report.markdown import table
from rl_design_space.report.runs import Runs
from rl_design_space.report.together import together
from rl_design_space.report.written import Written
from tests.report.readers import LearningReader
from tests.report.test_written import FRAMES, Own


class Interrupted(Own):
    """A report that is interrupted when all but its text is written."""

    def text(self, frames):
        os.kill(os.getpid(), signal.SIGINT)
        return []


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def write_two(folder: Path) -> None:
    with together(folder) as new:
        for name in ("a.csv", "b.md"):
            (new / name).write_text("new")


def write(report: Own, stem: Path) -> Written:
    return report.write_runs(Runs([], LearningReader([])), stem)


def test_an_interrupt_leaves_the_files_of_the_earlier_report_and_nothing_else(tmp_path: Path):
    write(Own(title="Mine"), tmp_path / "own")
    before = contents(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        write(Interrupted(title="Another"), tmp_path / "own")
    assert contents(tmp_path) == before
    with pytest.raises(KeyboardInterrupt):
        write(Interrupted(title="Another"), tmp_path / "new" / "own")
    assert contents(tmp_path) == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_waits_until_all_files_are_in_place(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def interrupted(path: Path, target: Path) -> None:
        os.kill(os.getpid(), number)
        path.replace(target)

    def handler(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "move", interrupted)
    earlier = signal.signal(number, handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            write_two(tmp_path)
        assert signal.getsignal(number) is handler
    finally:
        signal.signal(number, earlier)
    assert contents(tmp_path) == {"a.csv": b"new", "b.md": b"new"}


def test_a_link_stays_a_link_to_the_new_file(tmp_path: Path):
    paper, reports = tmp_path / "paper", tmp_path / "reports"
    paper.mkdir()
    reports.mkdir()
    (reports / "own.pdf").symlink_to(paper / "own.pdf")
    with together(reports) as new:
        (new / "own.pdf").write_text("new")
    assert (reports / "own.pdf").is_symlink()
    assert contents(paper) == {"own.pdf": b"new"}


def test_pdf_and_latex_of_an_earlier_report_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    def own(*formats: str) -> Own:
        made = Own(title="Mine", format=formats)
        object.__setattr__(made, "parts", (table(FRAMES[MAIN]),) * 2)
        return made

    stem = tmp_path / "own"
    # Files of others: the second is the table of another report, which has a text.
    for name in ("own-too.pdf", "own_3.tex", "own_3.md", "other.tex"):
        (tmp_path / name).write_text("another's")
    assert write(own("pdf", "latex"), stem).left == ()
    before = contents(tmp_path)
    written = write(own(), stem)
    assert [path.name for path in written.left] == ["own.pdf", "own.tex", "own_2.tex"]
    assert {name: before[name] for name in ("own.pdf", "own.tex", "own_2.tex")}.items() <= contents(tmp_path).items()
    assert Written.joined([written, written]).left == written.left * 2
    tell_of_left(written, written.left)
    some = write(own("pdf"), stem)
    assert [path.name for path in some.left] == ["own.tex", "own_2.tex"]
    tell_of_left(some, some.left)
    tell_of_left(some, ())
    what = "left from an earlier report; --format pdf latex writes them anew"
    assert capsys.readouterr().err == f"{stem}.pdf, own.tex, own_2.tex: {what}\n{stem}.tex, own_2.tex: {what}\n"
