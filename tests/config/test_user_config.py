"""The user's config folder: how it is set, what it shadows, and messages for errors in it."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rl_design_space import DesignPoint
from rl_design_space._paths import CONF
from rl_design_space.catalogue.search import searched
from rl_design_space.config import user_config
from rl_design_space.config.compose import shipped_config
from rl_design_space.errors import ConfigError
from rl_design_space.plan.planner import Planner

OPTION = "# Mine.\n_target_: own_way.Way\nwidth: 2\n"
MODULE = """
from dataclasses import dataclass
import numpy as np
from rl_design_space.design import cell_count

@dataclass(frozen=True)
class Way:
    width: int
    parts: tuple = ()

    def observation(self, world, goals):
        return np.zeros((*goals.shape, cell_count(world)), dtype=np.int64)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Create a config folder beside a module, and restore the process state afterwards."""
    monkeypatch.delenv(user_config.VARIABLE, raising=False)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "own_way.py", MODULE)
    write(tmp_path / "conf" / "representation" / "way.yaml", OPTION)
    yield tmp_path / "conf"
    sys.modules.pop("own_way", None)


def write(path: Path, content: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content, encoding="utf-8")


def chosen(folder: Path, *overrides: str) -> DesignPoint:
    return DesignPoint.from_overrides(["representation=way", *overrides], config_dir=folder)


@pytest.mark.parametrize(
    ("typed", "found", "rest"),
    [
        ("-m seed=1,2", None, "-m seed=1,2"),
        ("--config-dir here seed=1", "here", "seed=1"),
        ("seed=1 -cd here", "here", "seed=1"),
        ("--config-dir=here -m", "here", "-m"),
        ("--config-d here -c job", "here", "-c job"),
        ("--config-name other", None, "--config-name other"),
    ],
)
def test_the_flag_may_stand_anywhere(typed: str, found: str | None, rest: str):
    assert user_config.take_flag(typed.split()) == (found, rest.split())


def test_the_flag_needs_a_folder():
    with pytest.raises(ConfigError, match="--config-dir: needs a folder"):
        user_config.take_flag(["seed=1", "--config-dir"])


def test_one_folder_is_given():
    expected = r"--config-dir one, --config-dir two: should be given once; hydra.searchpath=\[DIR\] adds"
    with pytest.raises(ConfigError, match=expected):
        user_config.take_flag(["-cd", "one", "seed=1", "--config-dir=two"])


def test_a_missing_folder_is_named_as_typed(folder: Path, monkeypatch: pytest.MonkeyPatch):
    with pytest.raises(ConfigError, match="--config-dir cnof: there is no such folder"):
        user_config.use("cnof")
    monkeypatch.setenv(user_config.VARIABLE, "nowhere")
    with pytest.raises(ConfigError, match="RL_DESIGN_SPACE_CONFIG=nowhere: there is no such folder"):
        user_config.use()


def test_a_folder_is_shown_without_parent_references(folder: Path, tmp_path: Path):
    (tmp_path / "beside").mkdir(exist_ok=True)
    with user_config.used(Path("beside") / ".." / folder.name):
        assert user_config.user_folder() == folder
        assert user_config.flags() == ["--config-dir", "conf"]


def test_an_option_of_an_unused_folder_is_suggested(folder: Path):
    message = "representation=way: no such option; --config-dir conf would add it"
    with pytest.raises(ConfigError, match=message):
        DesignPoint.from_overrides(["representation=way"])
    with searched() as search, pytest.raises(ConfigError, match=message):
        search.check("representation", "way")


def test_a_command_names_the_folder_relative_to_the_current_one(folder: Path):
    assert user_config.flags() == []
    with user_config.used("conf"):
        assert user_config.flags() == ["--config-dir", "conf"]
        with shipped_config():
            assert Planner()(["representation=way"]).command == "rl-design-space --config-dir conf representation=way"
    assert user_config.VARIABLE not in os.environ


def test_user_modules_come_last_on_the_path(folder: Path):
    before = [*sys.path]
    user_config.use(folder)
    assert sys.path == [*before, str(folder.parent)]
    user_config.use(folder)
    assert sys.path == [*before, str(folder.parent)]
    del os.environ[user_config.VARIABLE]


def test_a_user_option_is_assembled_without_composition(folder: Path, monkeypatch: pytest.MonkeyPatch):
    with user_config.used(folder), shipped_config():
        planner = Planner()
        planner(["representation=way"])
        monkeypatch.setattr(planner.composer, "_compose", None)
        planner([])
        assert type(planner(["representation=way", "representation.width=7"]).point.representation).__name__ == "Way"


def test_lists_become_tuples(folder: Path):
    write(folder / "representation" / "way.yaml", OPTION + "parts: [1, [2, 3]]\n")
    assert chosen(folder).representation.parts == (1, (2, 3))


def test_user_files_shadow_shipped_files_of_the_same_name(folder: Path, capsys: pytest.CaptureFixture[str]):
    write(folder / "representation" / "ad_hoc.yaml", OPTION)
    assert type(DesignPoint.from_overrides([], config_dir=folder).representation).__name__ == "Way"
    assert type(DesignPoint.from_overrides([]).representation).__name__ == "AdHoc"
    with user_config.used(folder):
        user_config.tell_of_shadowing()
    told = Path("conf/representation/ad_hoc.yaml")
    assert capsys.readouterr().err == f"{told} is used in place of the shipped file of that name\n"


def test_the_shipped_folder_shadows_nothing():
    with user_config.used(CONF):
        assert user_config.shadowing() == []


# Errors in the folder.

MISTAKES = {
    "not YAML": (
        "_target_: own_way.Way\nwidth: [2\nparts: 3\n",
        [],
        r"conf/representation/way\.yaml:3:6: expected ',' or",
    ),
    "a tab": ("_target_: own_way.Way\n\twidth: 2\n", [], r"way\.yaml:2:1: found character '\\t' that cannot start"),
    "a key twice": (OPTION + "width: 3\n", [], r"way\.yaml:4:1: found duplicate key width"),
    "not even a mapping": ("- 1\n- 2\n", [], "representation"),
    "empty": ("", [], r"representation\._target_=\?\?\?: should name the class"),
    "a misspelt key": (
        OPTION + "widht: 3\n",
        [],
        r"representation\.widht: no such key; did you mean representation\.width",
    ),
    "a missing key": (
        "_target_: own_way.Way\n",
        [],
        r"representation\.width=\?\?\?: needs a value; Way has no default",
    ),
    "an interpolation": (
        "_target_: own_way.Way\nwidth: ${task.gaols}\n",
        [],
        r"representation\.width: .*'task\.gaols' not",
    ),
    "a misspelt class": (
        OPTION.replace("Way", "Wya"),
        [],
        r"_target_=own_way\.Wya: .*own_way\.py has no 'Wya'.* mean Way\?",
    ),
    "a misspelt module": (
        OPTION.replace("own_way", "own_wya"),
        [],
        r"_target_=own_wya\.Way: cannot be imported: No module named .own_wya.; looked in .* the installed packages",
    ),
    "a misspelt option": (
        OPTION,
        ["representation=wayy"],
        r"representation=wayy: no such option; did you mean .*=way\?",
    ),
    "a function": (
        OPTION.replace("Way", "cell_count"),
        [],
        r"_target_=own_way\.cell_count: should name a class",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_an_invalid_option_file_is_explained(name: str, folder: Path):
    content, overrides, message = MISTAKES[name]
    write(folder / "representation" / "way.yaml", content)
    with pytest.raises(ConfigError, match=message):
        chosen(folder, *overrides)


@pytest.mark.parametrize(
    ("module", "message"),
    [
        ("class Way(:\n", r"own_way\.Way: cannot be imported: .*own_way\.py:1: invalid syntax"),
        ("\n1 / 0\n", r"own_way\.Way: cannot be imported: ZeroDivisionError: division by zero \(.*own_way\.py:2\)"),
        ("import no_such_library\n", r"cannot be imported: No module named 'no_such_library' \(.*own_way\.py:1\)"),
        (MODULE.replace("observation", "observe"), r"own_way\.Way: .*Representation; it has no observation\(\)"),
        (
            MODULE
            + "    def __post_init__(self):\n        object.__setattr__(self, 'width', np.random.randint(10**9))\n",
            r"representation: own_way\.Way\.width is \d+ when it is built, and \d+ when it is built again",
        ),
    ],
    ids=["syntax", "exception", "library", "protocol", "random"],
)
def test_an_invalid_module_is_explained(module: str, message: str, folder: Path):
    write(folder.parent / "own_way.py", module)
    with pytest.raises(ConfigError, match=message):
        chosen(folder)
