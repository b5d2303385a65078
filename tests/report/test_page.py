"""The whole paper through the real commands, small: every report, and the page in a real browser."""

from __future__ import annotations

import base64
import csv
import re
from io import BytesIO
from pathlib import Path

import pytest
import yaml
from PIL import Image

from rl_design_space._paths import CONF
from tests.browser import needs_browser, opened, photographed
from tests.command_runner import Command, Completed, commands_in

SMALL = ("task.periods=6", "task.trials=12")
SECTIONS = yaml.safe_load((CONF / "study" / "paper.yaml").read_text(encoding="utf-8"))["report"]["sections"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("paper")


@pytest.fixture(scope="module")
def command(folder: Path, empty_database: Path) -> Command:
    return commands_in(folder, empty_database)


@pytest.fixture(scope="module")
def written(command: Command) -> Completed:
    command("rl-design-space", "study=paper", *SMALL)
    return command("rl-design-report", "all", *SMALL)


@pytest.fixture(scope="module")
def report(folder: Path, written: Completed) -> Path:
    return folder / "out" / "report"


def test_every_report_has_its_files(report: Path, written: Completed):
    names = {Path(line).name for line in written.stdout.splitlines()}
    expected = {f"{name}.{suffix}" for name in SECTIONS for suffix in ("png", "svg", "csv", "md")}
    assert expected | {"index.html"} <= names
    assert {path.name for path in report.iterdir()} == names


def test_every_table_and_figure_of_the_paper_is_on_the_page():
    assert set(SECTIONS) == {
        *(f"table{i}" for i in (1, 2, 3, 4)),
        *(f"fig{i}" for i in range(1, 6)),
        "claims",
        "readings",
    }


def test_the_page_is_one_file_that_fetches_nothing(report: Path):
    html = (report / "index.html").read_text(encoding="utf-8")
    assert re.findall(r'(?:src|srcset)="(?!data:)[^"]*"', html) == []
    assert re.findall(r"<(?:script|iframe|link rel=\"stylesheet\")", html) == []
    assert "url(" not in html
    assert html.count('src="data:image/png;base64,') == len(SECTIONS)


def test_every_picture_has_an_alternative_text(report: Path):
    html = (report / "index.html").read_text(encoding="utf-8")
    pictures = re.findall(r"<img [^>]*>", html)
    assert len(pictures) == len(SECTIONS)
    assert all(len(re.search(r'alt="([^"]*)"', picture)[1]) > 20 for picture in pictures)


def test_the_pictures_are_whole(report: Path):
    html = (report / "index.html").read_text(encoding="utf-8")
    pictures = re.findall(r'src="data:image/png;base64,([^"]*)"', html)
    for name, data in zip(SECTIONS, pictures, strict=True):
        with Image.open(BytesIO(base64.b64decode(data)), formats=["PNG"]) as picture:
            picture.load()
            assert min(picture.size) > 300, name


def test_every_report_gives_its_command_and_its_runs(report: Path):
    html = (report / "index.html").read_text(encoding="utf-8")
    with_runs = set()
    for name in SECTIONS:
        assert f"rl-design-report {name} " in html, name
        text = (report / f"{name}.md").read_text(encoding="utf-8")
        if "rl-design-space study=" in text:
            with_runs.add(name)
            assert f"tags.%22study.{name}%22" in html, name
    assert {"table4", "fig2", "claims"} <= with_runs


def test_the_ledger_has_the_columns_asked_for(report: Path):
    with (report / "claims.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0])[:7] == ["claim", "statement", "verdict", "value", "ci_low", "ci_high", "study"]
    verdicts = {row["verdict"] for row in rows}
    assert verdicts
    assert verdicts <= {"reproduced", "not reproduced", "undecided"}


def test_the_page_prints_its_verdicts(written: Completed):
    assert re.search(r"^  17 claims: \d+ reproduced, \d+ not reproduced, \d+ undecided$", written.stderr, re.M)


def test_fewer_periods_are_marked(report: Path):
    assert "quick look: 6 periods instead of 500" in (report / "index.html").read_text(encoding="utf-8")
    for name in SECTIONS:
        picture = (report / f"{name}.svg").read_text(encoding="utf-8")
        needs_runs = "rl-design-space study=" in (report / f"{name}.md").read_text(encoding="utf-8")
        assert ("quick look: 6 periods instead of 500" in picture) == needs_runs, name


def test_the_report_is_kept_with_the_summary_run(folder: Path, written: Completed):
    (page,) = (folder / "out" / "artifacts" / "sweeps").rglob("index.html")
    assert page.parent.name == "report"
    assert (page.parent / "claims.csv").exists()


def test_a_report_of_no_recorded_point_is_refused_and_replaces_nothing(command: Command, report: Path):
    page = (report / "index.html").read_bytes()
    said = command("rl-design-report", "all", *SMALL, "seed=76", status=2)
    assert said.stderr.startswith("error: study paper: none of its 581 points is recorded; `rl-design-space study=")
    assert (report / "index.html").read_bytes() == page


#: A page of some of the sections.
SHORT = """
includes: [table4, fig2, claims]
report:
  _target_: rl_design_space.report.Page
  title: Short
  sections: [table4, fig2, claims]
  verdicts: claims
  ui: http://127.0.0.1:5000
"""


def test_reports_of_points_that_are_missing_say_what_makes_them(command: Command, folder: Path):
    (folder / "own" / "conf" / "study").mkdir(parents=True)
    (folder / "own" / "conf" / "study" / "short.yaml").write_text(SHORT, encoding="utf-8")
    config, outputs = ("--config-dir", "own/conf"), "out/incomplete"
    command("rl-design-space", *config, "study=short", *SMALL, "shard=1/10", outputs=outputs)
    said = command("rl-design-report", *config, "short", *SMALL, outputs=outputs)
    makes = r"`rl-design-space --config-dir own/conf study=short .*`"
    assert re.search(rf"^missing: 2[3-7]\d of 290 points; {makes} makes them$", said.stderr, re.M)
    written = folder / outputs / "report"
    assert "issing" in (written / "index.html").read_text(encoding="utf-8")
    for name in ("table4", "fig2", "claims"):
        assert f"rl-design-space --config-dir own/conf study={name} " in (written / f"{name}.md").read_text(
            encoding="utf-8"
        )


@needs_browser
@pytest.mark.parametrize("width", [400, 1300], ids=["phone", "desk"])
def test_a_browser_shows_the_page_without_complaints(report: Path, tmp_path: Path, width: int):
    html, complaints = opened(report / "index.html", tmp_path / "profile", f"--window-size={width},900")
    assert complaints == []
    assert html.count("<h2") == len(SECTIONS) + 1
    photographed(report / "index.html", tmp_path / "profile", tmp_path / "page.png", width, 900)
    with Image.open(tmp_path / "page.png") as picture:
        colours = picture.convert("RGB").getcolors(maxcolors=2**24)
    assert len(colours) > 20


@needs_browser
def test_the_page_is_no_wider_than_a_phone(report: Path, tmp_path: Path):
    # The browser says itself how wide the document has become.
    page = tmp_path / "measured.html"
    html = (report / "index.html").read_text(encoding="utf-8")
    asking = "<script>document.title = `${document.documentElement.scrollWidth} of ${innerWidth}`</script></body>"
    page.write_text(html.replace("</body>", asking), encoding="utf-8")
    shown, _ = opened(page, tmp_path / "profile", "--window-size=500,900")
    found = re.search(r"<title>(\d+) of (\d+)</title>", shown)
    assert int(found[1]) <= int(found[2])
