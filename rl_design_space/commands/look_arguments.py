"""Arguments of all reports that say how they look: `report.look.Look`, on the command line."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    import pandas as pd

#: Suffixes of a file of labels.
_FILES = (".yaml", ".yml")
#: Metavar and help of each, by the name of its field. Those of the first group take several values.
_SEVERAL = {
    "labels": (
        "NAME=TEXT",
        "how names of parameters, of their values and of measures read: exploration.k=decay 'representation=ad_hoc=ad "
        "hoc'; or a YAML file of them. They are added to those in labels.yaml of --config-dir",
    ),
    "order": ("NAME=VALUES", "order of rows, columns and lines: reward=end_reward,each_success (default: the study's)"),
    "format": ("FORMAT", "what is written beside the usual files: pdf, latex (tables for booktabs)"),
}
_SINGLE = {
    "scale": ("SCALE", "of the values: linear or log; for compare and sensitivity ratio, too"),
    "colour_map": ("NAME", "of cells and lines, Matplotlib's or seaborn's: viridis, Blues, tab10"),
    "width": ("WIDTH", "of the picture: column, page, or inches"),
    "height": ("INCHES", "of the picture; follows from the width if left out"),
    "font_size": ("POINTS", "of most text; other text keeps its proportion to it"),
}
NAMES = (*_SEVERAL, *_SINGLE)
#: Maximum number of values that a note lists.
_SHOWN_VALUES = 12
#: Fields of some reports whose flags are named like them, too.
_ALSO = ("named", "top")
#: What may follow a flag, for tab completion.
CHOICES = {"--scale": ("linear", "log", "ratio"), "--width": ("column", "page"), "--format": ("pdf", "latex")}


def add_look(parser: argparse.ArgumentParser, names: Sequence[str] = NAMES) -> None:
    """Add the arguments of these names to a parser."""
    group = parser.add_argument_group("how it looks, as in the report: section of a study's file")
    for name in names:
        metavar, told = {**_SEVERAL, **_SINGLE}[name]
        several: dict[str, Any] = {"nargs": "+", "action": "extend", "default": []} if name in _SEVERAL else {}
        group.add_argument(flag_of(name), metavar=metavar, help=told, **several)


def flag_of(name: str) -> str:
    """Return the flag of a field."""
    return f"--{name.replace('_', '-')}"


def take_look(chosen: argparse.Namespace, names: Sequence[str] = NAMES) -> tuple[dict[str, Any], list[str]]:
    """Return the fields that were given, and the overrides of settings that follow them on the command line.

    Raises:
        ConfigError: a value is not allowed; the flag is named.
    """
    from rl_design_space.commands.where import where_of
    from rl_design_space.config.overrides import is_setting

    given: dict[str, Any] = {name: getattr(chosen, name) for name in names if getattr(chosen, name)}
    settings: list[str] = []
    for name in given.keys() & _SEVERAL.keys():
        settings += filter(is_setting, given[name])
        given[name] = [word for word in given[name] if not is_setting(word)]
    if "labels" in given:
        given["labels"] = _labels(given["labels"])
    if "order" in given:
        given["order"], _ = where_of(given["order"], flag_of("order"))
    check_look(given)
    return given, settings


def check_look(look: Mapping[str, Any]) -> None:
    """Refuse values that no report allows, before anything is read.

    Raises:
        ConfigError: a value is not allowed; the flag is named.
    """
    if not look:
        return
    from rl_design_space.config.build import construct
    from rl_design_space.report.look import Look

    with named_by_flags():
        construct(Look, look)


@contextmanager
def named_by_flags() -> Iterator[None]:
    """Let errors about these fields name their flags inside the context."""
    try:
        yield
    except ConfigError as error:
        pattern = rf"^({'|'.join((*NAMES, *_ALSO))})(?=[=.])"
        message = re.sub(pattern, lambda match: flag_of(match[1]), str(error), flags=re.MULTILINE)
        raise ConfigError(message) from error


def unused_labels(words: Sequence[str], runs: pd.DataFrame) -> Iterator[str]:
    """Yield a note on each label that was typed for a name that these runs do not have; those of files are for any.

    Args:
        words: of `--labels`.
        runs: a frame of runs.
    """
    from rl_design_space.config.overrides import is_setting
    from rl_design_space.learning.measures import CURVES, CURVES_ON_DEMAND
    from rl_design_space.report.parameters import text

    known = {*map(str, runs.columns), *CURVES, *CURVES_ON_DEMAND}
    for word in words:
        if _is_file(word) or is_setting(word):
            continue
        label = word.rpartition("=")[0]
        name, is_value, value = label.partition("=")
        if name not in known and not _is_measure(name):
            error = ConfigError.unknown("parameter or measure of these runs", name, known, "--labels ")
            yield f"unused: {str(error).partition(' (there is')[0]}"
        elif is_value and name in runs and value not in (there := list(dict.fromkeys(map(text, runs[name])))):
            yield f"unused: --labels {label}: no run has this value (there is {', '.join(there[:_SHOWN_VALUES])})"


def _is_measure(name: str) -> bool:
    from rl_design_space.config.measure_name import measure_of

    try:
        measure_of(name)
    except ConfigError:
        return False
    return True


def _is_file(word: str) -> bool:
    """Return whether a word of `--labels` is a file of labels."""
    return word.endswith(_FILES) and ("=" not in word or Path(word).is_file())


def _labels(words: Sequence[str]) -> dict[str, str]:
    """Return labels by name, those of files first.

    Raises:
        ConfigError: a word is neither NAME=TEXT nor a file of labels.
    """
    from rl_design_space.config.labels import labels_of

    files = [word for word in words if _is_file(word)]
    found: dict[str, str] = {}
    for word in files:
        found |= labels_of(Path(word))
    of_files = set(found)
    for word in words:
        name, equals, text = word.rpartition("=")
        if word in files:
            continue
        if name and equals and not text:
            raise ConfigError(f"--labels {word}: has no text; should be NAME=TEXT, such as {name}=decay")
        if not equals or not name:
            raise ConfigError(f"--labels {word}: should be NAME=TEXT, such as exploration.k=decay, or a YAML file")
        if name in found and name not in of_files:
            raise ConfigError(f"--labels {name}={found[name]} {word}: should be one text for a name")
        found[name] = text
        of_files.discard(name)
    return found
