"""Built-in plots of tables: the distribution of each KPI, and comparisons of planners with their intervals."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from pytest_lpb.report.comparison_section import relative_difference
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import kpi_title
from pytest_lpb.report.plots import Plot, default_registry
from pytest_lpb.report.scale import drawable
from pytest_lpb.run.summary import ALL
from pytest_lpb.shown import literal

VERDICT_COLOURS = {"better": "#2b8a5f", "worse": "#c23b3b"}
OTHER_COLOUR = "0.35"
MAX_SCENARIOS = 12  # side by side in one picture; beyond, all are pooled
WIDEST = 200.0  # [%] at which differences are cut off, as in the report


def kpi_pictures(data: ReportData) -> Iterator[tuple[str, ...]]:
    """One of every KPI that has values."""
    for kpi in data.kpis:
        if kpi.name in data.trials and drawable(data.trials[kpi.name].to_numpy(float)).any():
            yield (kpi.name,)


def kpi(data: ReportData, parts: tuple[str, ...], axes: Any) -> None:
    """Values of trials by planner, in each scenario; boxes are quartiles, whiskers 1.5 times their distance."""
    shown = next(kpi for kpi in data.kpis if kpi.name == parts[0])
    trials = data.trials[data.trials["success"].eq(True)] if shown.over == "solved" else data.trials
    trials = trials[drawable(trials[shown.name].to_numpy(float))]
    planners = list(dict.fromkeys(data.trials["planner"]))
    scenarios = list(dict.fromkeys(trials["scenario"]))
    if len(scenarios) > MAX_SCENARIOS:
        trials, scenarios = trials.assign(scenario="all scenarios"), ["all scenarios"]
    width = 0.8 / len(planners)
    for number, planner in enumerate(planners):
        for place, scenario in enumerate(scenarios):
            rows = trials[(trials["planner"] == planner) & (trials["scenario"] == scenario)]
            if len(rows):
                at = place + (number - 0.5 * (len(planners) - 1)) * width
                _box(axes, rows[shown.name].to_numpy(float), at, 0.9 * width, f"C{number % 10}")
    for number, planner in enumerate(planners):
        axes.plot([], [], "s", color=f"C{number % 10}", label=literal(planner))
    many = len(scenarios) > 2
    axes.set_xticks(
        range(len(scenarios)),
        list(map(literal, scenarios)),
        rotation=25 if many else 0,
        ha="right" if many else "center",
    )
    axes.set(ylabel=kpi_title(shown.name, shown.unit))
    axes.legend(loc="best", fontsize="small")


def _box(axes: Any, values: np.ndarray[Any, Any], at: float, width: float, colour: str) -> None:
    axes.boxplot(
        values,
        positions=[at],
        widths=width,
        patch_artist=True,
        manage_ticks=False,
        boxprops={"facecolor": colour, "alpha": 0.35, "edgecolor": colour},
        medianprops={"color": "black"},
        whiskerprops={"color": colour},
        capprops={"color": colour},
        flierprops={"marker": ".", "markersize": 3, "markeredgecolor": colour},
    )


def comparison_pictures(data: ReportData) -> Iterator[tuple[str, ...]]:
    """One of every pair of planners."""
    pairs = data.comparisons[["planner_a", "planner_b"]].drop_duplicates()
    for a, b in pairs.itertuples(index=False):
        yield (str(a), str(b))


def comparison(data: ReportData, parts: tuple[str, ...], axes: Any) -> None:
    """Differences of planner b to planner a over all scenarios in % of a's median, with 95 % intervals."""
    a, b = parts
    frame = data.comparisons
    frame = frame[(frame["planner_a"] == a) & (frame["planner_b"] == b) & (frame["scenario"] == ALL)]
    rows = [(row, relative_difference(row)) for row in frame.to_dict("records")]
    shown = [(row, shares) for row, shares in rows if shares is not None]
    for place, (row, shares) in enumerate(shown):
        middle, low, high = np.clip(shares, -WIDEST, WIDEST)
        colour = VERDICT_COLOURS.get(row["verdict"], OTHER_COLOUR)
        reach = [[max(middle - low, 0)], [max(high - middle, 0)]]
        axes.errorbar(middle, place, xerr=reach, fmt="o", color=colour, capsize=2, markersize=3)
    axes.axvline(0.0, color="0.6", linewidth=1)
    titles = {kpi.name: kpi_title(kpi.name, kpi.unit) for kpi in data.kpis}
    names = [titles.get(row["kpi"], str(row["kpi"])) for row, _ in shown]
    axes.set_yticks(range(len(shown)), names, fontsize=max(4.0, min(9.0, 160 / max(len(shown), 1))))
    axes.set(xlabel=f"{b} against {a}: difference [% of median], 95 % interval")
    axes.set_xscale("symlog", linthresh=10.0)
    axes.invert_yaxis()


default_registry.add(Plot("kpi", "run", kpi, pictures=kpi_pictures))
default_registry.add(Plot("comparison", "run", comparison, pictures=comparison_pictures))
