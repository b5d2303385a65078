"""The command `rl-design-report`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from rl_design_space.commands.messages import shown_as_messages
from rl_design_space.config import user_config
from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader


#: The study whose report is the page of all others.
_ALL = "paper"


class Report(Protocol):
    """What a study's file may name as its report."""

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write files called after the study into a folder.

        Args:
            study: whose points the report is about.
            reader: of the tracked runs; points without a run are missing, and shown as such.
            folder: made if need be.

        Returns:
            The paths written.
        """
        ...


def main() -> None:
    """Write a report; errors that a user can mend are one message and exit status 2."""
    from rl_design_space.commands import figures

    with shown_as_messages():
        folder, typed = user_config.take_flag(sys.argv[1:])
        user_config.use(folder)
        user_config.tell_of_shadowing()
        if typed and typed[0] in figures.WORDS:
            paths = figures.main(typed[0], typed[1:])
        else:
            arguments = _parser(typed).parse_intermixed_args(typed)
            name = _ALL if arguments.report == "all" else arguments.report
            paths = write_report(name, arguments.overrides)
        for path in paths:
            print(path)


def _parser(typed: list[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="rl-design-report",
        description="Write the report of a study from its tracked runs, into outputs/report.",
        epilog=_studies() if {"-h", "--help"} & set(typed) else None,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("report", help="name of a study, e.g. table4; all for every one and the page")
    parser.add_argument("overrides", nargs="*", help="overrides, as in rl-design-space: outputs=…, tracking.uri=…")
    # Taken before; here for --help.
    parser.add_argument(user_config.FLAG, "-cd", metavar="DIR", help="folder with options and studies of your own")
    return parser


def _studies() -> str:
    from rl_design_space.catalogue.overview import study_list
    from rl_design_space.catalogue.search import searched
    from rl_design_space.commands import figures

    with searched() as search:
        any_runs = [f"  {word:12} {what}" for word, what in figures.WORDS.items()]
        example = "example: rl-design-report heatmap --rows representation --cols exploration.k --study table4"
        return "\n".join(
            (
                "studies:",
                *study_list(search),
                "",
                "of any runs, see rl-design-report WORD --help:",
                *any_runs,
                "",
                example,
            )
        )


def write_report(name: str, overrides: list[str]) -> list[Path]:
    """Write the report of a study.

    Args:
        name: of the study.
        overrides: of the study's points and of the settings, as on the command line that ran it.

    Returns:
        The files written.

    Raises:
        ConfigError: there is no such report, or nothing was recorded.
    """
    from rl_design_space.config.compose import shipped_config
    from rl_design_space.plan.study import load_study
    from rl_design_space.run.settings import build_settings
    from rl_design_space.tracking.read import NoRuns

    with shipped_config():
        study = load_study(name, overrides)
    settings = build_settings(study.config)
    report: Report = study.report()
    reader = settings.tracking.reader() if study.plan else NoRuns()
    _tell_of_missing(study, reader)
    paths = report.write(study, reader, Path(settings.outputs) / "report")
    reader.attach(study.name, paths)
    return paths


def _tell_of_missing(study: Study, reader: Reader) -> None:
    """Say on stderr how many points have no run; refuse a report about nothing, which might replace a full one."""
    missing = len(study.plan) - len(reader.finished([planned.fingerprint for planned in study.plan]))
    if missing and missing == len(study.plan):
        raise ConfigError(f"study {study.name}: none of its {missing} points is recorded; `{study.command}` makes them")
    if missing:
        print(f"missing: {missing} of {len(study.plan)} points; `{study.command}` makes them", file=sys.stderr)
