"""From a registered plot to a picture, with matplotlib's Agg canvas and no global state."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pytest_lpb.errors import LpbError

if TYPE_CHECKING:
    import pandas as pd

    from pytest_lpb.report.data import ReportData
    from pytest_lpb.report.plots import Plot

SIZE = (5.6, 3.8)  # [inch]
DPI = 150  # of PNG files
MAX_SVG_BYTES = 60_000  # beyond, the report holds a PNG image
# Neither dates nor random ids: the same data give the same file.
METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "pdf": {"CreationDate": None},
    "svg": {"Date": None},
}
STYLE: Any = {
    "svg.hashsalt": "pytest-lpb",
    "svg.fonttype": "path",
    "font.size": 10.0,
    "axes.grid": True,
    "grid.alpha": 0.3,
}


class PlotFailure(LpbError):  # noqa: N818 - what happened to a plot, told in the report
    """A user's plot raised, or its raw data cannot be read."""


@dataclass(frozen=True)
class Drawing:
    """One picture to draw: a plot, and the trials in it."""

    plot: Plot
    data: ReportData
    parts: tuple[str, ...]  # scenario, planner and seed, as far as the plot's scope needs them
    node_ids: tuple[str, ...]

    @property
    def title(self) -> str:
        """What the picture shows."""
        return " · ".join((self.plot.name.replace("_", " "), *self.parts))


def drawings(plot: Plot, data: ReportData, trials: pd.DataFrame) -> Iterator[Drawing]:
    """The pictures of a plot for these trials (rows of `data.trials`)."""
    if plot.scope == "run":
        yield Drawing(plot, data, (), tuple(trials["node_id"]))
    elif plot.scope == "scenario":
        for scenario, rows in trials.groupby("scenario", sort=False):
            yield Drawing(plot, data, (*str(scenario).split("/"),), tuple(rows["node_id"]))
    else:
        for row in trials.to_dict("records"):
            parts = (*str(row["scenario"]).split("/"), str(row["planner"]), f"seed{row['seed']}")
            yield Drawing(plot, data, parts, (str(row["node_id"]),))


def figure_of(drawing: Drawing) -> Figure:
    """The picture as a matplotlib figure. Raises PlotFailure when the plot raised or raw data are missing."""
    plot = drawing.plot
    figure = Figure(figsize=SIZE, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.set_title(drawing.title, fontsize=10)
    try:
        trajectories = [drawing.data.trajectory_of(node_id) for node_id in drawing.node_ids]
        trajectories = [trajectory for trajectory in trajectories if len(trajectory)]
        if not trajectories:
            raise PlotFailure(f"plot {plot.name!r}: no recorded motion in {', '.join(drawing.node_ids)}")
        plot.function(trajectories[0] if plot.scope == "trial" else trajectories, axes)
    except PlotFailure:
        raise
    except Exception as error:  # whatever the user's function raises is told, and the report goes on
        raise PlotFailure(f"plot {plot.name!r} ({plot.place}): {type(error).__name__}: {error}") from error
    return figure


def save(drawing: Drawing, target: Path, formats: Sequence[str]) -> list[Path]:
    """Write the picture to `target` with each format's suffix. Raises PlotFailure."""
    with mpl.rc_context(STYLE):
        figure = figure_of(drawing)
        target.parent.mkdir(parents=True, exist_ok=True)
        paths = [target.parent / f"{target.name}.{suffix}" for suffix in formats]
        for suffix, path in zip(formats, paths, strict=True):
            _render(drawing, figure, suffix, path)
    return paths


def data_uri(drawing: Drawing) -> str:
    """The picture as an image in a data URI: SVG, or PNG where that is smaller. Raises PlotFailure."""
    with mpl.rc_context(STYLE):
        figure = figure_of(drawing)
        buffer = io.BytesIO()
        _render(drawing, figure, "svg", buffer)
        kind = "svg+xml"
        if buffer.tell() > MAX_SVG_BYTES:
            buffer, kind = io.BytesIO(), "png"
            _render(drawing, figure, "png", buffer)
    return f"data:image/{kind};base64,{base64.b64encode(buffer.getvalue()).decode()}"


def _render(drawing: Drawing, figure: Figure, suffix: str, target: Path | io.BytesIO) -> None:
    try:
        figure.savefig(target, format=suffix, dpi=DPI, metadata=METADATA.get(suffix))
    except (ValueError, RuntimeError, TypeError) as error:  # such as text that cannot be set
        plot = drawing.plot
        raise PlotFailure(f"plot {plot.name!r} ({plot.place}): {type(error).__name__}: {error}") from error
