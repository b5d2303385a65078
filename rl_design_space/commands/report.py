"""The command `rl-design-report`."""

from __future__ import annotations

import argparse
import errno
import gc
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from rl_design_space._version import __version__
from rl_design_space.commands.arguments import Parser
from rl_design_space.commands.folders import report_folder
from rl_design_space.commands.interrupts import end_quickly, handle_interrupts
from rl_design_space.commands.look_arguments import add_look, named_by_flags, take_look
from rl_design_space.commands.messages import shown_as_messages, tell
from rl_design_space.config import user_config
from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.reader import Reader

#: New objects after which Python looks for garbage, and how often it then looks through older ones. Imports and plans
#: make hundreds of thousands that stay; to look through all of them again and again takes a tenth of a report.
_COLLECTION = 100_000, 10, 10
#: What running an interrupted command again is for.
_PURPOSE = "to write the report"
#: End of the `_target_` of a page of reports.
_PAGE = ".Page"


def main() -> None:
    """Write a report; an error that the user can fix is one message and exit status 2."""
    handle_interrupts(_PURPOSE)
    gc.set_threshold(*_COLLECTION)
    end_quickly()
    with shown_as_messages(_PURPOSE):
        from rl_design_space.commands import completion, figure_words

        if (completed := completion.answer(sys.argv[1:])) is not None:
            print(completed)
            return
        folder, typed = user_config.take_flag(sys.argv[1:])
        user_config.use(folder)
        user_config.tell_of_shadowing()
        _check_first(typed)
        if typed and typed[0] in figure_words.WORDS:
            paths = figure_words.main(typed[0], typed[1:])
        else:
            arguments = _parser(typed).parse_intermixed_args(typed)
            look, settings = take_look(arguments)
            _check_study(arguments.report, [*arguments.overrides, *settings])
            if arguments.title:
                look["title"] = arguments.title
            name = study_of_all() if arguments.report == "all" else arguments.report
            paths = write_report(
                name,
                [*arguments.overrides, *settings],
                look,
                _options(typed, [arguments.report, *arguments.overrides, *settings]),
            )
        for path in paths:
            print(path)


def _check_first(typed: list[str]) -> None:
    """Refuse settings before the name of the report.

    Raises:
        ConfigError: the first argument is a setting.
    """
    from rl_design_space.config.overrides import is_override

    if typed and is_override(typed[0]):
        name = next((word for word in typed if not word.startswith("-") and not is_override(word)), "table4")
        raise ConfigError(f"{typed[0]}: the name of a report comes first, as in `rl-design-report {name} {typed[0]}`")


def _check_study(report: str, overrides: Sequence[str]) -> None:
    """Refuse another study than that whose report is asked for.

    Raises:
        ConfigError: an override names one.
    """
    from rl_design_space.config.overrides import is_of_study

    for override in overrides:
        name = override.partition("=")[2]
        if is_of_study(override) and name != report:
            raise ConfigError(f"{override}: `rl-design-report {name}` writes the report of that study")


def _parser(typed: list[str]) -> Parser:
    parser = Parser(
        prog="rl-design-report",
        description="Write the report of a study from its tracked runs, into outputs/report.",
        epilog=_studies() if {"-h", "--help"} & set(typed) else None,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("report", help="name of a study, e.g. table4; all for the page of all reports")
    parser.add_argument("overrides", nargs="*", help="overrides, as in rl-design-space: outputs=…, tracking.uri=…")
    parser.add_argument("--title", default="", help="of the picture")
    add_look(parser)
    parser.add_argument("--version", action="version", version=f"rl-design-report {__version__}")
    # Parsed before, see `main`; listed here for --help.
    parser.add_argument(user_config.FLAG, "-cd", metavar="DIR", help="folder with options and studies of your own")
    return parser


def _studies() -> str:
    from rl_design_space.catalogue.overview import study_list
    from rl_design_space.catalogue.search import searched
    from rl_design_space.commands import figure_words

    with searched() as search:
        any_runs = [f"  {word:12} {what}" for word, what in figure_words.WORDS.items()]
        example = "example: rl-design-report heatmap --rows representation --cols exploration.k --study table4"
        heading = "of any runs, see rl-design-report WORD --help:"
        return "\n".join(["studies:", *study_list(search), "", heading, *any_runs, "", example])


def study_of_all() -> str:
    """Return the study whose report collects all others: the default page, or the only page.

    Raises:
        ConfigError: there is no such study, or there are several.
    """
    from rl_design_space.catalogue.search import searched

    pages: dict[bool, list[str]] = {True: [], False: []}
    with searched() as search:
        for name in search.options("study"):
            if _PAGE not in search.text(f"study/{name}"):  # takes a fraction of the time
                continue
            node = search.node(f"study/{name}")
            report = node.get("report") if isinstance(node, Mapping) else None
            if isinstance(report, Mapping) and str(report.get("_target_")).endswith(_PAGE):
                pages[report.get("default") is True].append(name)
    found = pages[True] or pages[False]
    if len(found) != 1:
        expected = "needs one study whose report is a Page with default: true"
        raise ConfigError(f"all: {expected}, not {len(found)} ({', '.join(found) or 'none'})")
    return found[0]


def _options(typed: Sequence[str], others: Sequence[str]) -> tuple[str, ...]:
    """Return what was typed beside the name of the report and the overrides."""
    return tuple(word for word in typed if word not in others)


def write_report(
    name: str, overrides: list[str], look: Mapping[str, Any] = MappingProxyType({}), options: tuple[str, ...] = ()
) -> list[Path]:
    """Write the report of a study.

    Args:
        name: of the study.
        overrides: of the study's points and of the settings, as on the command line that ran it.
        look: fields of `report.look.Look` that replace those of the study's file.
        options: how they were typed, for the command that the report names.

    Returns:
        The files written.

    Raises:
        ConfigError: the study has no report, or none of its points is recorded.
    """
    from rl_design_space.commands.left_files import tell_of_left
    from rl_design_space.commands.main_numbers import tell_numbers
    from rl_design_space.commands.unused_variables import tell_of_unused_variables
    from rl_design_space.commands.watching import counting
    from rl_design_space.config.compose import shipped_config
    from rl_design_space.plan.study import load_study
    from rl_design_space.run.settings import build_settings
    from rl_design_space.tracking.reader import FoundRuns, NoRuns

    with shipped_config():
        study = load_study(name, overrides)
    settings = build_settings(study.config)
    folder = report_folder(settings)
    tell_of_unused_variables(settings.tracking)
    report = study.report()
    if look:
        with named_by_flags():
            report = report.looking(look)
        study = replace(study, report_options=options)
    fingerprints = [planned.fingerprint for planned in study.plan]
    with counting("reading runs", len(fingerprints)) as count, named_by_flags():
        reader = FoundRuns(settings.tracking.reader(), fingerprints, count) if study.plan else NoRuns()
        _report_missing(study, reader)
        paths: list[Path] = report.write(study, reader, folder)
    from rl_design_space.report.written import left_of, numbers_of  # the report has imported what it needs

    tell_numbers(numbers_of(paths))
    tell_of_left(paths, left_of(paths))
    try:
        reader.attach(study.name, paths)
    except OSError as error:
        if error.errno not in (errno.EROFS, errno.EACCES):
            raise
        reason = f"{error.filename} cannot be written to ({error.strerror})"
        tell(f"not added to the files of the sweep's run: {reason}")
    return paths


def _report_missing(study: Study, reader: Reader) -> None:
    """Print to stderr how many points have no run; refuse an empty report, which might replace a full one.

    Raises:
        ConfigError: no point has a run.
    """
    missing = len(study.plan) - len(reader.finished([planned.fingerprint for planned in study.plan]))
    if missing and missing == len(study.plan):
        raise ConfigError(f"study {study.name}: none of its {missing} points is recorded; `{study.command}` makes them")
    if missing:
        tell(f"missing: {missing} of {len(study.plan)} points; `{study.command}` makes them")
