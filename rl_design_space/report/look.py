"""How a report looks: the options that all reports take, on the command line and in YAML alike."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from functools import cached_property
from typing import Annotated, Any, ClassVar

import matplotlib as mpl
import pandas as pd
from pydantic import BeforeValidator, Field, model_validator
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.labels import checked, own_labels
from rl_design_space.errors import ConfigError
from rl_design_space.report import style
from rl_design_space.report.words import Words

#: Widths of a column and of a page of a journal with two columns, in inches.
WIDTHS = {"column": 3.5, "page": 7.16}
#: What can be written beside the usual files.
FORMATS = PNG, SVG, PDF, LATEX = "png", "svg", "pdf", "latex"
LINEAR, LOG, RATIO = "linear", "log", "ratio"
#: Even in lightness from end to end, so that it can be read in grey and by colour-blind readers.
COLOURS = "cividis_r"
#: Inches: width below which panels are one above the other.
_NARROW = 5.0
#: Sides of a picture in inches, and sizes of text in points.
_SIDES, _SIZES = (1.0, 50.0), (3.0, 40.0)


def _number(value: Any, least: float, most: float, expected: str) -> float | None:
    """Return a number that was given as such or as text.

    Raises:
        ValueError: it is no number within the limits.
    """
    if value is None:
        return None
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not least <= number <= most:
        raise ValueError(expected)
    return number


def _width(value: Any) -> float | None:
    widths = " or ".join(f"{name} ({inches:g})" for name, inches in WIDTHS.items())
    expected = f"should be {widths}, or inches from {_SIDES[0]:g} to {_SIDES[1]:g}"
    return _number(WIDTHS.get(value, value) if isinstance(value, str) else value, *_SIDES, expected)


def _height(value: Any) -> float | None:
    return _number(value, *_SIDES, f"should be inches from {_SIDES[0]:g} to {_SIDES[1]:g}")


def _font_size(value: Any) -> float | None:
    return _number(value, *_SIZES, f"should be points from {_SIZES[0]:g} to {_SIZES[1]:g}")


def _formats(value: Any) -> tuple[str, ...]:
    listed = value if isinstance(value, list | tuple) else [value]
    formats = [each for part in listed for each in str(part).replace(",", " ").split()]
    if unknown := [each for each in formats if each not in FORMATS]:
        raise ValueError(f"there is no format {unknown[0]}; should be one or several of {', '.join(FORMATS)}")
    return tuple(dict.fromkeys(formats))


def _colour_map(value: Any) -> Any:
    if isinstance(value, str) and value and value not in mpl.colormaps:
        import seaborn  # noqa: F401  # which registers its own

    if isinstance(value, str) and value and value not in mpl.colormaps:
        nearest = get_close_matches(value, list(mpl.colormaps), n=1, cutoff=0.5)
        hint = f"did you mean {nearest[0]}?" if nearest else "there are viridis, cividis, Blues, tab10 and others"
        raise ValueError(f"Matplotlib and seaborn have no such colour map; {hint}")
    return value


def _order(value: Any) -> Any:
    if not isinstance(value, Mapping):
        return value
    return {name: list(each) if isinstance(each, list | tuple) else [each] for name, each in value.items()}


_Inches = float | str | None


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Look:
    """How a report looks.

    Attributes:
        labels: how names read: of parameters (`exploration.k`), of their values (`representation=ad_hoc`) and of
            measures. They are added to those in `labels.yaml` of the config folder. Files of numbers keep the names.
        order: values of parameters in the order of their rows, columns and lines, by name; by itself that of the study.
        scale: of the values: linear or log; ratio where it makes sense; by itself, log if they span a decade.
        colour_map: of cells and lines: a name of Matplotlib's or seaborn's.
        width: of the picture: column (3.5), page (7.16), or inches.
        height: of the picture in inches; follows from the width if left out.
        font_size: of most text in points; text of the picture keeps its proportions.
        format: what is written beside PNG, SVG, CSV and Markdown: pdf, latex (tables for the package booktabs).
    """

    labels: Annotated[dict[str, str], BeforeValidator(checked, json_schema_input_type=dict[str, str | float])] = Field(
        default_factory=dict
    )
    order: Annotated[dict[str, list[Any]], BeforeValidator(_order, json_schema_input_type=dict[str, Any])] = Field(
        default_factory=dict
    )
    scale: str = ""
    colour_map: Annotated[str, BeforeValidator(_colour_map, json_schema_input_type=str)] = ""
    width: Annotated[float | None, BeforeValidator(_width, json_schema_input_type=_Inches)] = None
    height: Annotated[float | None, BeforeValidator(_height, json_schema_input_type=float | None)] = None
    font_size: Annotated[float | None, BeforeValidator(_font_size, json_schema_input_type=float | None)] = None
    format: Annotated[tuple[str, ...], BeforeValidator(_formats, json_schema_input_type=str | list[str])] = ()

    #: Of order, scale and colour_map, those that make a difference to the report.
    choosable: ClassVar[Sequence[str]] = ()
    #: What the scale may be.
    scales: ClassVar[Sequence[str]] = (LINEAR, LOG)
    #: Names of these options that mean something else in the report.
    own: ClassVar[Sequence[str]] = ()
    #: Whether labels are for names that only this report has, or for bare values; its text writes them itself.
    names_cells: ClassVar[bool] = False

    @model_validator(mode="after")
    def _makes_a_difference(self) -> Look:
        """Refuse options that would change nothing."""
        for name in ("order", "colour_map", "scale"):
            value = getattr(self, name)
            if not value or type(self) is Look or name in self.own:
                continue
            if name not in self.choosable:
                raise ConfigError.at(name, value, f"{type(self).__name__} has no {name.replace('_', ' ')} to choose")
            if name == "scale" and value not in self.scales:
                raise ConfigError.at(name, value, f"should be {' or '.join(self.scales)}")
        return self

    @cached_property
    def words(self) -> Words:
        """How names and values read in picture and text."""
        labels = {name: text for name, text in self.labels.items() if "=" in name} if self.names_cells else self.labels
        return Words({**own_labels(), **labels})

    @cached_property
    def table_words(self) -> Words:
        """How names and values read in tables for LaTeX, in which a number is never a name."""
        return Words({name: text for name, text in {**own_labels(), **self.labels}.items() if not name.isdigit()})

    @property
    def is_narrow(self) -> bool:
        """Whether panels are one above the other, because the picture is too narrow for two side by side."""
        return self.width is not None and self.width < _NARROW

    @property
    def cells_map(self) -> str:
        """Colour map of cells."""
        return self.colour_map or COLOURS

    def colours(self, number: int, palette: str = "colorblind") -> Sequence[Any]:
        """Return so many colours: of the colour map, or of a palette of seaborn if none was chosen."""
        return style.colours(number, self.colour_map or palette)

    def is_log(self, values: pd.Series[float], *, by_itself: bool | None = None) -> bool:
        """Return whether values are shown on a logarithmic scale.

        Args:
            values: that are shown.
            by_itself: whether they are if no scale was chosen; if they span a decade, if None.

        Raises:
            ConfigError: such a scale was chosen, and a value is not positive.
        """
        least = float(values.min()) if len(values) else math.nan
        if self.scale == LOG and least <= 0:
            raise ConfigError.at("scale", LOG, f"needs numbers above 0; the least is {style.number(least)}")
        if self.scale or by_itself is not None:
            return self.scale == LOG if self.scale else bool(by_itself)
        return least > 0 and float(values.max()) / least >= style.DECADE
