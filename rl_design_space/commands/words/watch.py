"""Draw what the agent of a period knows and does: values, greedy actions, visits and paths."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rl_design_space.commands.arguments import Parser
from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    from rl_design_space.run.settings import Settings
    from rl_design_space.run.subject import Subject

_ANIMATIONS = ("gif", "html")
_DEFAULTS = {"period": "worst", "trial": "last"}
_EPILOG = (
    "examples: rl-design-space watch 3f2a period=worst trial=worst; "
    "rl-design-space watch representation=direction exploration=linear exploration.k=0.02 period=16 --animate html"
)


def main(arguments: Sequence[str]) -> None:
    """Learn a period again, show it in the terminal, and write its pictures.

    Raises:
        ConfigError: there is no such run, period or trial, or an override is not understood.
    """
    parser = Parser(
        prog="rl-design-space watch",
        description="Learn a period again and draw it into outputs/report: PNG, SVG, and an animation over its trials.",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "subject",
        nargs="*",
        metavar="RUN_ID | KEY=VALUE",
        help="id of a run or fingerprint of a point, or a prefix of it; or overrides, as for running a point. "
        "period=worst|median|best|NUMBER (by the steps of all trials; default: worst), "
        "trial=first|last|worst|median|best|NUMBER (default: last), and settings such as outputs=DIR",
    )
    parser.add_argument(
        "--animate", action="append", choices=_ANIMATIONS, default=[], help="how it grows over the trials, as a file"
    )
    parser.add_argument("--frames", type=int, default=None, help="number of pictures of an animation, at most")
    options = parser.parse_intermixed_args(arguments)
    chosen, overrides = _chosen(options.subject)

    from rl_design_space.commands.folders import report_folder
    from rl_design_space.commands.messages import tell
    from rl_design_space.commands.period_grids import period_grids
    from rl_design_space.commands.terminal import console
    from rl_design_space.commands.watching import watched as with_progress
    from rl_design_space.config.overrides import is_setting
    from rl_design_space.report.inside.animation import FRAMES
    from rl_design_space.report.inside.watched import watch
    from rl_design_space.run.settings import reading_settings_of

    settings = reading_settings_of(list(filter(is_setting, overrides)))
    if options.frames is not None and options.frames < 2:
        raise ConfigError.at("--frames", options.frames, "should be a number of at least 2")
    subject = _subject([each for each in overrides if not is_setting(each)], settings)
    folder = report_folder(settings)
    total_steps = None if subject.steps is None else subject.steps.sum(axis=1, dtype=float)
    watched = watch(subject.point, chosen["period"], chosen["trial"], total_steps=total_steps, name=subject.name)
    if subject.steps is not None and (subject.steps[watched.period] != watched.inside.steps).any():
        tell(f"{subject.key}: these are not the recorded steps; the code that they depend on has changed since")
    console.print(period_grids(watched), soft_wrap=True)
    folder.mkdir(parents=True, exist_ok=True)
    stem = folder / f"watch-{subject.key}-period-{watched.period}"
    paths = watched.save(f"{stem}-trial-{watched.trial}")
    if options.animate:
        frames = watched.frames(options.frames or FRAMES, with_progress)
        if "gif" in options.animate:
            paths.append(frames.write_gif(stem.with_suffix(".gif")))
        if "html" in options.animate:
            paths.append(frames.write_page(stem.with_suffix(".html")))
    for path in paths:
        print(path)


def _chosen(words: Sequence[str]) -> tuple[dict[str, int | str], list[str]]:
    """Return the period and the trial, and the other words."""
    chosen: dict[str, int | str] = dict(_DEFAULTS)
    others = []
    for word in words:
        key, _, value = word.partition("=")
        if key in chosen:
            chosen[key] = int(value) if re.fullmatch(r"-?\d{1,18}", value) else value
        else:
            others.append(word)
    return chosen, others


def _subject(words: Sequence[str], settings: Settings) -> Subject:
    """Return the point of a run id, or of overrides.

    Raises:
        ConfigError: there is no such run, an id is given together with overrides, or an override is not understood.
    """
    from rl_design_space.config.overrides import is_override
    from rl_design_space.run.subject import of_overrides, of_run

    names = [word for word in words if not is_override(word)]
    if not names:
        return of_overrides(words)
    if len(words) > 1:
        other = next(word for word in words if word != names[0])
        raise ConfigError(f"{other}: beside the run {names[0]}, only period=, trial= and settings are taken")
    return of_run(settings.tracking.reader(), names[0])
