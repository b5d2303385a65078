"""The page: the reports of several studies in one file that needs no network."""

from __future__ import annotations

import base64
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass as plain_dataclass
from dataclasses import replace
from datetime import UTC, datetime
from multiprocessing import get_context
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any
from urllib.parse import unquote

from jinja2 import Environment, PackageLoader, StrictUndefined
from markdown_it import MarkdownIt
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space._version import __version__
from rl_design_space.config import user_config
from rl_design_space.learning.cores import available_threads
from rl_design_space.plan.study import Study
from rl_design_space.report.beside import can_be_copied
from rl_design_space.report.page_claims import PageClaim, page_claims
from rl_design_space.report.together import together
from rl_design_space.report.written import MainNumbers, Written, left_of, numbers_of

if TYPE_CHECKING:
    from rl_design_space.tracking.reader import Reader

_TEMPLATE = "page.html.jinja"
#: The page to explore runs, if it was written into the same folder, and the command that writes it.
_EXPLORER, _EXPLORING = "explore.html", "rl-design-report explore"
#: From so many reports on, several processes write them: each may take seconds to start.
_MANY = 4


@plain_dataclass(frozen=True)
class Section:
    """A report on the page.

    Attributes:
        name: of its study.
        title: its heading.
        body: everything below, as HTML.
        runs: address of its runs in the MLflow UI; empty if it needs no runs.
    """

    name: str
    title: str
    body: str
    runs: str


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Page:
    """A page of reports.

    Attributes:
        title: of the page.
        sections: names of the studies whose reports it holds, in their order.
        verdicts: the study among them with the claims, which stand on top.
        multiverse: the study whose report tells under what the claims hold; the page shows it if it is in its folder,
            and otherwise says how to make it. None if empty.
        ui: address of the MLflow UI, for links to the runs.
        default: whether `rl-design-report all` writes this page.
        look: fields of `Look` for all of its reports, such as `{format: pdf}`.
    """

    title: str
    sections: Annotated[tuple[str, ...], Field(strict=False, min_length=1)]
    verdicts: str
    multiverse: str = ""
    ui: str
    default: bool = False
    look: dict[str, Any] = Field(default_factory=dict)

    def write(self, study: Study, reader: Reader, folder: Path) -> Written:
        """Write the files of every report and index.html into a folder, see `Report.write`.

        The main numbers are those of the verdicts.
        """
        paths: list[Path] = []
        left: list[Path] = []
        sections = []
        numbers: tuple[MainNumbers, ...] = ()
        parts = [study.another(name) for name in self.sections]
        for part, written in zip(parts, _write_all(parts, reader, folder, self.look), strict=True):
            paths += written
            left += left_of(written)
            if part.name == self.verdicts:
                numbers = numbers_of(written)
            (text,) = (path for path in written if path.suffix == ".md")
            runs = reader.link(self.ui, part.name) if part.plan else ""
            sections.append(_section(part.name, text, runs))
        multiverse = folder / self.multiverse if self.multiverse else None
        if multiverse and (text := multiverse.with_suffix(".md")).exists():
            sections.insert(0, _section(self.multiverse, text, reader.link(self.ui, self.multiverse)))
        else:
            multiverse = None
        page = folder / "index.html"
        claims = page_claims(folder / f"{self.verdicts}.csv", multiverse)
        explorer = _EXPLORER if (folder / _EXPLORER).exists() else ""
        with together(folder) as new:
            (new / page.name).write_text(self.render(study, sections, claims, explorer), encoding="utf-8")
        return Written([*paths, page], numbers, left)

    def looking(self, look: Mapping[str, Any]) -> Page:
        """Return the same page with other values of the fields of `Look`; a title is that of the page."""
        of_reports = {name: value for name, value in look.items() if name != "title"}
        return replace(self, title=look.get("title", self.title), look={**self.look, **of_reports})

    def render(self, study: Study, sections: list[Section], claims: Sequence[PageClaim], explorer: str = "") -> str:
        """Return the page as HTML.

        Args:
            study: the study of the page.
            sections: its reports.
            claims: as the top of the page shows them.
            explorer: address of the page to explore the runs; empty if it was not written.
        """
        loader = PackageLoader("rl_design_space.report", "templates")
        environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
        periods = sorted({planned.point.task.periods for planned in study.plan})
        precise = any(planned.point.task.precision is not None for planned in study.plan)
        return environment.get_template(_TEMPLATE).render(
            title=self.title,
            sections=sections,
            claims=claims,
            counts=Counter(claim.verdicts[0][1] for claim in claims),
            multiverse=self.multiverse,
            explorer=explorer,
            exploring=_EXPLORING,
            has_multiverse=any(section.name == self.multiverse for section in sections),
            command=study.command,
            report_command=study.report_command,
            points=len(study.plan),
            periods=f"{'at least ' if precise else ''}{' or '.join(map(str, periods))}",
            mark=study.mark,
            version=__version__,
            written=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        )


def _write_all(
    parts: Sequence[Study], reader: Reader, folder: Path, look: Mapping[str, Any] = MappingProxyType({})
) -> list[list[Path]]:
    """Write the reports of studies into a folder, in several processes if they are many; return the files of each."""
    workers = min(available_threads(), len(parts))
    if workers == 1 or len(parts) < _MANY:
        return [_write(part, reader, folder, look) for part in parts]
    is_copied = can_be_copied()
    if is_copied:  # copies need not import anything again
        for part in parts:
            part.report()  # imports what writes it
    with ProcessPoolExecutor(workers, get_context("fork" if is_copied else "spawn")) as pool:
        # Those that take longest first, so that none of them is left at the end: what needs no points is computed.
        order = sorted(range(len(parts)), key=lambda index: -(len(parts[index].plan) or math.inf))
        writing = {
            index: pool.submit(_write, replace(parts[index], included=(), planner=None), reader, folder, dict(look))
            for index in order
        }
        try:
            return [writing[index].result() for index in range(len(parts))]
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)  # the end of the block would wait for all of them
            raise


def _write(part: Study, reader: Reader, folder: Path, look: Mapping[str, Any]) -> list[Path]:
    user_config.use()  # the folder that the process which started this one uses
    paths: list[Path] = part.report().looking(look).write(part, reader, folder)
    return paths


def _section(name: str, text: Path, runs: str) -> Section:
    """Return a report as a section of the page, its pictures inside.

    Args:
        name: of its study.
        text: its Markdown file, beside its pictures.
        runs: address of its runs in the MLflow UI.
    """
    heading, _, rest = text.read_text(encoding="utf-8").partition("\n")
    body: str = MarkdownIt("commonmark", {"html": False}).enable("table").render(rest)
    body = re.sub(r'src="([^":]+\.png)"', lambda found: f'src="{_inlined(text.parent / unquote(found[1]))}"', body)
    return Section(name, heading.lstrip("# "), _in_boxes(body), runs)


def _inlined(picture: Path) -> str:
    return f"data:image/png;base64,{base64.b64encode(picture.read_bytes()).decode()}"


def _in_boxes(body: str) -> str:
    """Put each table into a box, which scrolls sideways where the page is narrow, and headings below the section's."""
    body = body.replace("<table>", '<div class="wide"><table>').replace("</table>", "</table></div>")
    return body.replace("<h2>", "<h3>").replace("</h2>", "</h3>")
