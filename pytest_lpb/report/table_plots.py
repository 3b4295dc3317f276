"""Built-in plots of tables: success, the distribution of each KPI, and comparisons of planners with their intervals."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from pytest_lpb.report.comparison_section import relative_difference
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import minus
from pytest_lpb.report.palette import COLOURS, styles_of
from pytest_lpb.report.plots import Plot, default_registry
from pytest_lpb.report.scale import drawable
from pytest_lpb.report.success import RATE, common_rate_name, solved
from pytest_lpb.report.titles import compared_title, timing_mark, value_title
from pytest_lpb.run.summary import ALL, summary_table
from pytest_lpb.shown import literal

VERDICT_COLOURS = {"better": "#2b8a5f", "worse": "#c23b3b"}
OTHER_COLOUR = "0.35"
MAX_SCENARIOS = 12  # side by side in one picture; beyond, all are pooled
WIDEST = 200.0  # [%] at which differences are cut off, as in the report
PERCENTAGES = (-200, -50, -10, 0, 10, 50, 200)  # ticks of differences
ROW_INCH = 0.16  # height of a comparison


def success_pictures(data: ReportData) -> Iterator[tuple[str, ...]]:
    """One of the run, unless it has no trials."""
    if len(data.trials):
        yield ()


def success(data: ReportData, parts: tuple[str, ...], axes: Any) -> None:  # noqa: ARG001 - there is one picture
    """Trials solved, and success rate of each planner with its 95 % interval, as in the rows `all` of summary.csv."""
    table = summary_table(data.trials, [])
    rows = {str(row["planner"]): row for row in table[table["scenario"] == ALL].to_dict("records")}
    styles = [style for name, style in styles_of(data).items() if name in rows]
    for place, style in enumerate(styles):
        rate, low, high = (rows[style.name][f"success_{part}"] for part in ("rate", "low", "high"))
        axes.barh(place, rate, color=COLOURS[style.colour], alpha=0.6)
        axes.errorbar(rate, place, xerr=[[max(rate - low, 0)], [max(high - rate, 0)]], color="k", capsize=4)
    name = common_rate_name(rows[style.name] for style in styles)
    axes.set(xlabel=name if name == RATE else f"{RATE}, {name}", xlim=(0, 1.01))
    axes.set_yticks(range(len(styles)), [literal(f"{style.name} {solved(rows[style.name])}") for style in styles])
    axes.invert_yaxis()


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
    tried = set(data.trials["planner"])
    planners = [style for name, style in styles_of(data).items() if name in tried]
    scenarios = list(dict.fromkeys(trials["scenario"]))
    if len(scenarios) > MAX_SCENARIOS:
        trials, scenarios = trials.assign(scenario="all scenarios"), ["all scenarios"]
    width = 0.8 / len(planners)
    for number, planner in enumerate(planners):
        for place, scenario in enumerate(scenarios):
            rows = trials[(trials["planner"] == planner.name) & (trials["scenario"] == scenario)]
            if len(rows):
                at = place + (number - 0.5 * (len(planners) - 1)) * width
                _box(axes, rows[shown.name].to_numpy(float), at, 0.9 * width, COLOURS[planner.colour])
    for planner in planners:
        axes.plot([], [], "s", color=COLOURS[planner.colour], label=literal(planner.name))
    many = len(scenarios) > 2
    axes.set_xticks(
        range(len(scenarios)),
        list(map(literal, scenarios)),
        rotation=25 if many else 0,
        ha="right" if many else "center",
    )
    axes.set(ylabel=value_title(shown) + timing_mark(shown, data))
    axes.legend(loc="best", fontsize="small")


def _box(axes: Any, values: np.ndarray[Any, Any], at: float, width: float, colour: str) -> None:
    axes.boxplot(
        values,
        positions=[at],
        widths=width,
        patch_artist=True,
        manage_ticks=False,
        boxprops={"facecolor": colour, "alpha": 0.35, "edgecolor": colour},
        medianprops={"color": colour, "linewidth": 2.0},  # all that is seen of values that do not differ
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
        middle, low, high = np.clip([shares[0] if share is None else share for share in shares], -WIDEST, WIDEST)
        colour = VERDICT_COLOURS.get(row["verdict"], OTHER_COLOUR)
        reach = [[max(middle - low, 0)], [max(high - middle, 0)]]
        axes.errorbar(middle, place, xerr=reach, fmt="o", color=colour, capsize=2, markersize=3)
    axes.axvline(0.0, color="0.6", linewidth=1)
    titles = {kpi.name: compared_title(kpi) + timing_mark(kpi, data) for kpi in data.kpis}
    names = [titles.get(row["kpi"], str(row["kpi"])) for row, _ in shown]
    width, height = axes.figure.get_size_inches()
    axes.figure.set_size_inches(width, max(height, ROW_INCH * len(shown) + 1.0))
    axes.set_yticks(range(len(shown)), names, fontsize=8)
    axes.set_xscale("symlog", linthresh=10.0)
    axes.set_xticks(PERCENTAGES, [minus(str(percentage)) for percentage in PERCENTAGES])
    axes.tick_params(axis="x", which="minor", bottom=False)
    axes.set(xlim=(-1.15 * WIDEST, 1.15 * WIDEST))
    beyond = f"; beyond {WIDEST:g} % at the edge" if any(abs(shares[0] or 0.0) > WIDEST for _, shares in shown) else ""
    what = "difference [% of median,\nof success: percentage points]"
    axes.set(xlabel=f"{literal(b)} against {literal(a)}: {what}\n95 % interval{beyond}")
    axes.invert_yaxis()


default_registry.add(Plot("success", "run", success, pictures=success_pictures))
default_registry.add(Plot("kpi", "run", kpi, pictures=kpi_pictures))
default_registry.add(Plot("comparison", "run", comparison, pictures=comparison_pictures))
