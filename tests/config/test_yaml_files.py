"""Config files that are no UTF-8, begin with a byte-order mark, or hold numbers of YAML 1.1."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from yaml import YAMLError

from rl_design_space._paths import CONF
from rl_design_space.catalogue.choices import choice
from rl_design_space.catalogue.options import Options
from rl_design_space.catalogue.search import searched
from rl_design_space.config import yaml_files, yaml_parser
from rl_design_space.config.compose import Composer, shipped_config
from rl_design_space.config.user_config import used
from rl_design_space.config.yaml_parser import parse_yaml
from rl_design_space.errors import ConfigError

TORUS = "# Größe\n_target_: rl_design_space.design.Torus\nsize: "
FILES = {
    "world/fine.yaml": f"{TORUS}10\n".encode(),
    "world/latin.yaml": f"{TORUS}10\n".encode("latin-1"),
    "world/utf16.yaml": f"{TORUS}10\n".encode("utf-16-le"),
    "world/nul.yaml": f"{TORUS}10\0\n".encode(),
    "world/octal.yaml": f"{TORUS}010\n".encode(),
    "world/zeros.yaml": f"{TORUS}[8, -0_17]\n".encode(),
    "world/folder.yaml/placeholder": b"",
    "preset/hours.yaml": b"# @package _global_\ntask: {trials: 1:30}\n",
    "preset/seconds.yaml": b"# @package _global_\nreward: {step: 1:30.5}\n",
    "preset/text.yaml": b"# @package _global_\noutputs: '010'\ntracking: {experiment: 1:30 at 10:40, curves: [a0_7]}\n",
    "preset/mark.yaml": "\ufeff# @package _global_\n# Größe\nseed: 5\n".encode(),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("own") / "conf"
    for name, content in FILES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder


@pytest.fixture(scope="module")
def composer(folder: Path) -> Iterator[Composer]:
    with used(folder), shipped_config():
        yield Composer()


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("world=latin", "latin.yaml:1: should be UTF-8, but holds the byte 0xf6"),
        ("world=utf16", "utf16.yaml:1: should be UTF-8, but holds the byte 0xf6"),
        ("world=nul", "unacceptable character #x0000"),
        ("world=octal", 'octal.yaml:3:7: 010 is 8 in YAML, a number in base 8; write 8, or "010" if it is text'),
        ("world=zeros", "zeros.yaml:3:11: -0_17 is -15 in YAML"),
        ("+preset=hours", "hours.yaml:2:16: 1:30 is 90 in YAML, a number in base 60"),
        ("+preset=seconds", "seconds.yaml:2:16: 1:30.5 is 90.5 in YAML"),
    ],
)
def test_a_file_that_cannot_be_read_as_it_is_meant_is_named(override: str, message: str, composer: Composer):
    with pytest.raises(ConfigError) as caught:
        composer.config([override])
    assert message in str(caught.value)


def test_text_that_looks_like_such_a_number_is_left(composer: Composer):
    config = composer.config(["+preset=text"])
    assert (config.outputs, config.tracking.experiment, config.tracking.curves) == ("010", "1:30 at 10:40", ["a0_7"])


def test_a_byte_order_mark_is_skipped(composer: Composer):
    config = composer.config(["+preset=mark"])
    assert config.seed == 5
    assert "preset" not in config


def test_one_unreadable_file_does_not_prevent_the_list(folder: Path):
    with searched(str(folder)) as search:
        options = {option.name: option for option in choice(search, Options(search), "world").options}
    assert {"fine", "latin", "utf16", "nul", "octal", "torus"} <= set(options)
    assert (options["fine"].summary, options["fine"].error) == ("Größe", "")
    assert "should be UTF-8" in options["latin"].error


def test_a_file_is_parsed_once_and_read_again_when_it_changes(folder: Path, monkeypatch: pytest.MonkeyPatch):
    parsed: list[str] = []
    monkeypatch.setattr(yaml_files, "check_limits", lambda text, shown: parsed.append(text))
    (folder / "world" / "again.yaml").write_text("size: 4\n", encoding="utf-8")
    source = yaml_files.YamlFiles("test", f"file://{folder}")
    first = source.load_config("world/again").config
    first.size = 5
    assert source.load_config("world/again").config == {"size": 4}
    assert parsed == ["size: 4\n"]
    (folder / "world" / "again.yaml").write_text("size: 6\n", encoding="utf-8")
    assert source.load_config("world/again").config == {"size": 6}


@pytest.mark.parametrize("text", ["3", "true"])
def test_a_file_without_keys_is_refused(text: str, folder: Path):
    (folder / "world" / "bare.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=r"bare\.yaml: should hold keys and values, not "):
        yaml_files.YamlFiles("test", f"file://{folder}").load_config("world/bare")


def test_shipped_files_hold_the_same_whichever_parser_reads_them(monkeypatch: pytest.MonkeyPatch):
    texts = {path: path.read_text(encoding="utf-8") for path in CONF.rglob("*.yaml")}
    quick = {path: parse_yaml(text, path) for path, text in texts.items()}
    monkeypatch.setattr(yaml_parser, "CONF", Path("elsewhere"))
    assert {path: repr(parse_yaml(text, path)) for path, text in texts.items()} == {
        path: repr(values) for path, values in quick.items()
    }


@pytest.mark.parametrize("text", ["a: 1\na: 2", "a: [1", "a: \tb: 1", "a: 1\n b: 2", "\0"])
def test_errors_in_shipped_files_are_those_of_other_files(text: str):
    messages = []
    for folder in (CONF, Path("elsewhere")):
        with pytest.raises(YAMLError) as error:
            parse_yaml(text, folder / "any.yaml")
        messages.append(str(error.value).replace(str(folder), ""))
    assert messages[0] == messages[1]
