"""The users' own plots in the report: once per run, per scenario, or of the trials in the pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import islice

import pandas as pd

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.plots import Plot, default_registry
from pytest_lpb.report.scenes import representative
from pytest_lpb.report.view import PlannerStyle, UserFigure

MAX_FIGURES_PER_PLOT = 16


def plot_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> list[UserFigure] | None:  # noqa: ARG001
    """The users' own plots; None without any."""
    return user_figures(data) or None


def user_figures(data: ReportData, plots: Sequence[Plot] | None = None) -> list[UserFigure]:
    """Every plot that is not built in, as images (None: those registered)."""
    chosen = [entry for entry in (default_registry if plots is None else plots) if not entry.builtin]
    if not chosen or data.trials.empty:
        return []
    from pytest_lpb.report.drawing import Drawing, PlotFailure, data_uri, drawings

    def drawn(drawing: Drawing) -> UserFigure:
        try:
            return UserFigure(drawing.title, data_uri(drawing))
        except PlotFailure as failure:
            return UserFigure(drawing.title, "", str(failure))

    shown = pd.concat([representative(rows) for _, rows in data.trials.groupby("scenario", sort=False)])
    return [
        drawn(drawing)
        for entry in chosen
        for drawing in islice(
            drawings(entry, data, shown if entry.scope == "trial" else data.trials), MAX_FIGURES_PER_PLOT
        )
    ]
