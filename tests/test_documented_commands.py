"""The commands of the documentation pages work as written, in the order of the page."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.documented import DOCS, File, Typed, commands_as_written, parts_of, run, seen_by_the_shell
from tests.tracking.stores import copy_database

#: Pages with tests of their own: they contain files, or need a server.
_ELSEWHERE = {"configs.md", "components.md", "python.md", "clusters.md", "server.md"}
EVERY_PAGE = [*DOCS.rglob("*.md"), DOCS.parent / "README.md", DOCS.parent / "CONTRIBUTING.md"]
PAGES = [DOCS.parent / "README.md", *(page for page in sorted(DOCS.glob("*.md")) if page.name not in _ELSEWHERE)]


def typed(page: Path) -> list[Typed]:
    """Return the commands of a page, except those that run until Ctrl-C."""
    return [part for part in parts_of(page) if isinstance(part, Typed) and part.words[1:2] != ("ui",)]


def test_the_pages_contain_commands():
    assert sum(map(len, map(typed, PAGES))) > 15


@pytest.fixture(scope="module")
def folder(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the commands of all pages are run."""
    folder = tmp_path_factory.mktemp("reader")
    (folder / "temporary").mkdir()
    copy_database(empty_database, folder / "outputs" / "mlflow.db")
    return folder


@pytest.fixture(scope="module")
def already() -> set[Typed]:
    """Commands that were run before: in the folder, where the same command again would do nothing.

    Those that say what there is are run by tests/test_documented_configs.py, if that page has them.
    """
    return {command for command in typed(DOCS / "configs.md") if command.words[1:2] in {("list",), ("show",)}}


@pytest.mark.parametrize("page", [page for page in PAGES if typed(page)], ids=lambda page: page.stem)
def test_the_commands_of_a_page_work(page: Path, folder: Path, already: set[Typed]):
    for part in parts_of(page):
        if isinstance(part, File):
            (folder / part.path).parent.mkdir(parents=True, exist_ok=True)
            (folder / part.path).write_text(part.text, encoding="utf-8")
    for command in typed(page):
        if command in already:
            continue
        already.add(command)
        done = run(command.words, folder)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "error" not in done.stderr.lower(), command.words
        assert done.stdout


@pytest.mark.parametrize("page", EVERY_PAGE, ids=lambda page: page.stem)
def test_commands_reach_the_program_as_they_are_written(page: Path):
    assert {line: seen for line in commands_as_written(page) if (seen := seen_by_the_shell(line))} == {}


def test_what_a_shell_would_take_for_itself_is_found():
    assert seen_by_the_shell('report --filter "params.`world.size` = 1"  # a `comment`') == "``"
    assert seen_by_the_shell("rl-design-space x=[1] 'y=[2]' z=$HOME \"a;b\"") == "[]"


@pytest.mark.parametrize("page", EVERY_PAGE, ids=lambda page: page.stem)
def test_links_lead_to_existing_files(page: Path):
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if not target.startswith("http"):
            assert (page.parent / target).exists(), target
