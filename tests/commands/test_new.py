"""`rl-design-space new`: the starter files work without changes, and nothing is overwritten."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rl_design_space.commands.words import new
from rl_design_space.commands.words.new import KINDS, main, write_starter
from rl_design_space.config import user_config
from rl_design_space.errors import ConfigError


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, empty."""
    monkeypatch.delenv(user_config.VARIABLE, raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def tree(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_the_starter_files_pass_their_tests(folder: Path):
    for kind in KINDS:
        write_starter(kind, f"my_{kind}", folder / "conf")
    modules = {f"my_{kind}.py" for kind in KINDS} - {"my_study.py"}
    group = {"actions": "msa"}
    tests = {f"test_{'study_' * (kind == 'study')}my_{kind}.py" for kind in KINDS}
    assert tree(folder) == modules | tests | {f"conf/{group.get(kind, kind)}/my_{kind}.yaml" for kind in KINDS}
    # Only the package and pytest are needed.
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "error"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{2 * len(modules) + 1} passed" in done.stdout


def test_it_prints_the_files_and_the_next_commands(folder: Path, capsys: pytest.CaptureFixture[str]):
    main(["world", "windy"])
    assert capsys.readouterr().out.splitlines() == [
        "wrote windy.py",
        "wrote conf/world/windy.yaml",
        "wrote test_windy.py",
        "next:",
        "  python -m pytest test_windy.py",
        "  rl-design-space --config-dir conf world=windy task.periods=50",
    ]


def test_a_study_may_have_the_name_of_a_component(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(new, "find_spec", lambda name: None)
    main(["reward", "even"])
    main(["study", "even"])
    printed = capsys.readouterr().out
    assert tree(folder) == {
        "even.py",
        "test_even.py",
        "test_study_even.py",
        "conf/reward/even.yaml",
        "conf/study/even.yaml",
    }
    assert printed.splitlines()[-5:] == [
        "  pip install pytest",
        "  python -m pytest test_study_even.py",
        "  rl-design-space --config-dir conf study=even plan=true",
        "  rl-design-space --config-dir conf study=even",
        "  rl-design-report --config-dir conf even",
    ]


def test_it_writes_beside_the_config_folder_in_use(folder: Path, monkeypatch: pytest.MonkeyPatch):
    (folder / "elsewhere" / "mine").mkdir(parents=True)
    monkeypatch.setenv(user_config.VARIABLE, "elsewhere/mine")
    main(["reward", "even"])
    assert tree(folder) == {"elsewhere/even.py", "elsewhere/mine/reward/even.yaml", "elsewhere/test_even.py"}


@pytest.mark.parametrize("existing", ["windy.py", "conf/world/windy.yaml", "test_windy.py"])
def test_it_overwrites_nothing(existing: str, folder: Path):
    (folder / existing).parent.mkdir(parents=True, exist_ok=True)
    (folder / existing).write_text("mine", encoding="utf-8")
    with pytest.raises(ConfigError, match=f"{existing}: exists already; nothing was written"):
        main(["world", "windy"])
    assert tree(folder) == {existing}
    assert (folder / existing).read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["wrold", "windy"], "wrold: no such kind; did you mean world?"),
        (["world", "Windy"], "NAME=Windy: should be the name of a Python module"),
        (["world", "class"], "NAME=class: should be the name of a Python module"),
        (["world", "../windy"], "should be the name of a Python module"),
        (["world", "torus"], "NAME=torus: a shipped world has this name"),
        (["study", "table4"], "NAME=table4: a shipped study has this name"),
        (["world", "random"], "NAME=random: a module has this name already"),
        (["world", "numpy"], "NAME=numpy: a module has this name already"),
    ],
    ids=" ".join,
)
def test_a_name_that_cannot_be_used_is_refused(words: list[str], message: str, folder: Path):
    with pytest.raises(ConfigError) as caught:
        main(words)
    assert message in str(caught.value)
    assert tree(folder) == set()
