"""How values and paths of a period grow over its trials: a GIF, and a page with a slider."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from rl_design_space.analysis.snapshot import Snapshot, snapshot
from rl_design_space.learning.replay import Replay
from rl_design_space.report.inside.picture import Picture, told
from rl_design_space.report.style import styled
from rl_design_space.report.watching import Watch, unwatched

_TEMPLATE = "inside.html.jinja"
#: Frames of an animation if nothing else is wanted.
FRAMES = 30
_DOTS_PER_INCH = 80
#: Milliseconds that a picture of a GIF is shown, and the last one.
_SHOWN, _LAST = 350, 2500
_COLOURS = 256


def trials_shown(trials: int, frames: int, also: Iterable[int] = ()) -> list[int]:
    """Return the trials of an animation, more of the early than of the late ones.

    Args:
        trials: number of trials of the period.
        frames: how many of them are shown, at most.
        also: trials that are shown in any case.
    """
    every = np.arange(trials)
    if frames < trials:
        # Learning is fastest in the beginning.
        every = np.unique(np.rint(np.linspace(0, 1, frames) ** 1.6 * (trials - 1)).astype(int))
    return sorted({*every.tolist(), *also})


class Frames:
    """The pictures of a period after chosen trials, on one colour scale.

    Args:
        inside: the period, with history and paths.
        trials: numbers of the trials, ascending.
        title: first line of each picture.
        watch: shows how far the drawing is.
    """

    def __init__(self, inside: Replay, trials: Sequence[int], title: str, watch: Watch = unwatched) -> None:
        self.trials, self.title = list(trials), title
        snapshots = [snapshot(inside, trial) for trial in trials]
        self.texts = [told(inside, each) for each in snapshots]
        self.images = list(self._drawn(Picture(inside, snapshots[-1], title, tuple(snapshots)), snapshots, watch))

    @styled()
    def _drawn(self, picture: Picture, snapshots: Sequence[Snapshot], watch: Watch) -> Iterator[Image.Image]:
        figure = picture.figure
        figure.set_dpi(_DOTS_PER_INCH)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()  # type: ignore[no-untyped-call]
        figure.set_layout_engine("none")  # all parts keep their places
        for each in watch(snapshots, "drawing trials"):
            picture.show(each)
            canvas.draw()  # type: ignore[no-untyped-call]
            pixels = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
            yield Image.fromarray(pixels).convert("RGB")

    def write_gif(self, path: Path) -> Path:
        """Write an animated GIF, which is repeated for ever."""
        shown = [_SHOWN] * (len(self.images) - 1) + [_LAST]
        # Median cut, the default, gives the path the colour of the goals.
        first, *others = (image.quantize(_COLOURS, method=Image.Quantize.MAXCOVERAGE) for image in self.images)
        first.save(path, save_all=True, append_images=others, duration=shown, loop=0, optimize=False)
        return path

    def write_page(self, path: Path) -> Path:
        """Write a page with a slider, one file that needs no network."""
        frames = [
            {"trial": trial, "text": text, "png": _encoded(image)}
            for trial, text, image in zip(self.trials, self.texts, self.images, strict=True)
        ]
        loader = PackageLoader("rl_design_space.report", "templates")
        environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
        width, height = self.images[0].size
        page = environment.get_template(_TEMPLATE).render(title=self.title, frames=frames, width=width, height=height)
        path.write_text(page, encoding="utf-8")
        return path


def _encoded(image: Image.Image) -> str:
    content = BytesIO()
    image.save(content, format="PNG")
    return f"data:image/png;base64,{base64.b64encode(content.getvalue()).decode()}"
