"""From a registered plot to a picture, with matplotlib's Agg canvas and no global state."""

from __future__ import annotations

import base64
import io
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.errors import LpbError
from pytest_lpb.shown import literal

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
    if plot.pictures is not None:
        for parts in plot.pictures(data):
            yield Drawing(plot, data, parts, ())
    elif plot.scope == "run":
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
    axes.set_title(literal(drawing.title), fontsize=10)
    with _faults_told(plot):
        if plot.pictures is not None:
            plot.function(drawing.data, drawing.parts, axes)
            return figure
        trajectories = [drawing.data.trajectory_of(node_id) for node_id in drawing.node_ids]
        if not plot.without_rows:
            trajectories = [trajectory for trajectory in trajectories if len(trajectory)]
        if not trajectories:
            raise PlotFailure(f"plot {plot.name!r}: no recorded motion in {', '.join(drawing.node_ids)}")
        plot.function(trajectories[0] if plot.scope == "trial" else trajectories, axes)
    return figure


@contextmanager
def _faults_told(plot: Plot) -> Iterator[None]:
    """Whatever a user's function raises, SystemExit and pytest.fail too, is a PlotFailure; warnings are ignored."""
    try:
        with warnings.catch_warnings():
            # Whether a picture is drawn must not depend on whether warnings are errors.
            warnings.simplefilter("ignore")
            yield
    except (PlotFailure, KeyboardInterrupt):
        raise
    except BaseException as error:
        raise PlotFailure(f"plot {plot.name!r} ({plot.place}): {type(error).__name__}: {error}") from error


def save(drawing: Drawing, target: Path, formats: Sequence[str]) -> list[Path]:
    """Write the picture to `target` with each format's suffix. Raises PlotFailure; RecordingError: cannot write."""
    with mpl.rc_context(STYLE):
        figure = figure_of(drawing)
        pictures = {suffix: _render(drawing, figure, suffix) for suffix in formats}
    return [replace_file(target.parent / f"{target.name}.{suffix}", picture) for suffix, picture in pictures.items()]


def data_uri(drawing: Drawing) -> str:
    """The picture as an image in a data URI: SVG, or PNG where that is smaller. Raises PlotFailure."""
    with mpl.rc_context(STYLE):
        figure = figure_of(drawing)
        kind, picture = "svg+xml", _render(drawing, figure, "svg")
        if len(picture) > MAX_SVG_BYTES:
            kind, picture = "png", _render(drawing, figure, "png")
    return f"data:image/{kind};base64,{base64.b64encode(picture).decode()}"


def _render(drawing: Drawing, figure: Figure, suffix: str) -> bytes:
    buffer = io.BytesIO()
    with _faults_told(drawing.plot):  # such as text that cannot be set
        figure.savefig(buffer, format=suffix, dpi=DPI, metadata=METADATA.get(suffix))
    return buffer.getvalue()
