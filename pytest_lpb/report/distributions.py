"""Success bars with Wilson intervals, and every KPI's distribution, planner by planner in each scenario."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pytest_lpb.report.data import ReportData, ReportedKpi
from pytest_lpb.report.numbers import count, finite, show, unit_text
from pytest_lpb.report.packing import packed
from pytest_lpb.report.scale import Scale, drawable, scale_for
from pytest_lpb.report.success import success_text
from pytest_lpb.report.titles import MARK, value_title
from pytest_lpb.report.view import BarGroup, BarRow, BoxGroup, BoxRow, KpiFigure, KpiSection, PlannerStyle
from pytest_lpb.run.contention import contended

FloatArray = NDArray[np.float64]

BOX_FROM = 5  # values from which quartiles are drawn
MAX_POINTS = 200  # dots per row
MAX_TOLD = 5  # values too large to draw that are told
MAX_ROWS = 1000  # planners x scenarios in one figure
DIRECTIONS = {"lower": "lower is better", "higher": "higher is better"}


def kpi_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> KpiSection | None:
    """Success and every KPI with values; None without any."""
    success = success_groups(data.summary, styles)
    figures, without_values = kpi_figures(data, styles)
    if not success and not figures:
        return None
    return KpiSection(
        options=[(figure.group, figure.name, figure.title) for figure in figures],
        without_values=without_values,
        packed=packed(
            {
                "success": [
                    [group.name, [[row.style.number, row.rate, row.low, row.high, row.label] for row in group.rows]]
                    for group in success
                ],
                "figures": {figure.name: _listed(figure) for figure in figures},
            }
        ),
    )


def _listed(figure: KpiFigure) -> dict[str, Any]:
    return {
        "title": figure.title,
        "notes": figure.notes,
        "ticks": [[tick.at, tick.label] for tick in figure.ticks],
        "zero": figure.zero,
        "groups": [
            [
                group.name,
                [
                    [
                        row.style.number,
                        row.points,
                        row.median,
                        row.box,
                        row.whiskers,
                        row.label,
                        row.number,
                        row.description,
                    ]
                    for row in group.rows
                ],
            ]
            for group in figure.groups
        ],
    }


def success_groups(summary: pd.DataFrame, styles: Mapping[str, PlannerStyle]) -> list[BarGroup]:
    """Success rate of every planner: all scenarios first, then one by one."""
    names = sorted(dict.fromkeys(summary["scenario"]), key=lambda name: name != "all") if len(summary) else []
    if len(names) == 2 and names[0] == "all":
        names = names[1:]
    groups = []
    for name in names:
        rows = {row["planner"]: row for row in summary[summary["scenario"] == name].to_dict("records")}
        title = "all scenarios" if name == "all" else str(name)
        present = [(rows[planner], style) for planner, style in styles.items() if planner in rows]
        groups.append(BarGroup(title, [_bar(row, style) for row, style in present]))
    return groups


def _bar(row: Mapping[Any, Any], style: PlannerStyle) -> BarRow:
    rate, low, high = (finite(row[f"success_{part}"]) for part in ("rate", "low", "high"))
    return BarRow(
        style=style,
        rate=_percent(rate),
        low=_percent(low),
        high=_percent(high),
        label=success_text(row),
    )


def _percent(rate: float | None) -> float | None:
    return None if rate is None else round(100 * min(max(rate, 0.0), 1.0), 2)


def kpi_figures(data: ReportData, styles: Mapping[str, PlannerStyle]) -> tuple[list[KpiFigure], list[str]]:
    """A figure for every KPI with values, and the names of those without."""
    figures, empty = [], []
    for kpi in data.kpis:
        figure = _kpi_figure(data, kpi, styles) if kpi.name in data.trials else None
        if figure is None:
            empty.append(kpi.name)
        else:
            figures.append(figure)
    return figures, empty


def _kpi_figure(data: ReportData, kpi: ReportedKpi, styles: Mapping[str, PlannerStyle]) -> KpiFigure | None:
    trials = data.trials[data.trials["success"].eq(True)] if kpi.over == "solved" else data.trials
    trials = trials.assign(**{kpi.name: trials[kpi.name].astype(float)})
    finite_ones = trials[np.isfinite(trials[kpi.name])]
    if finite_ones.empty:
        return None
    can_be_drawn = drawable(finite_ones[kpi.name].to_numpy())
    trials, too_large = finite_ones[can_be_drawn], finite_ones[~can_be_drawn]
    scale = scale_for(trials[kpi.name].to_numpy(), may_be_logarithmic=True) if len(trials) else Scale(0.0, 1.0)
    unit = unit_text(kpi.unit)
    groups, rows = [], 0
    for scenario, members in trials.groupby("scenario", sort=False):
        found = {str(name): part[kpi.name].to_numpy() for name, part in members.groupby("planner")}
        boxes = [_box(found[name], style, scale, unit) for name, style in styles.items() if name in found]
        rows += len(boxes)
        if rows > MAX_ROWS:
            break
        groups.append(BoxGroup(str(scenario), boxes))
    return KpiFigure(
        name=kpi.name,
        title=value_title(kpi),
        group=kpi.group,
        notes=[*_notes(kpi, trials, scale, complete=rows <= MAX_ROWS), *_not_drawn(too_large, kpi.name)],
        ticks=scale.ticks() if groups else [],
        zero=_thousandths(scale, [0.0])[0] if not scale.logarithmic and scale.low < 0 < scale.high else None,
        groups=groups,
    )


def _notes(kpi: ReportedKpi, trials: pd.DataFrame, scale: Scale, *, complete: bool) -> list[str]:
    notes = [DIRECTIONS[kpi.direction]] if kpi.direction in DIRECTIONS else []
    notes.append("solved trials only" if kpi.over == "solved" else "trials that have a value")
    if scale.logarithmic:
        notes.append("logarithmic axis")
    disturbed = int(contended(trials, kpi).sum())
    if disturbed:
        notes.append(f"{MARK} timing contended in {disturbed} of {count(len(trials), 'trial')}")
    if not complete:
        notes.append(f"the first {MAX_ROWS} rows only; all values are in trials.csv")
    return notes


def _not_drawn(trials: pd.DataFrame, kpi_name: str) -> list[str]:
    """A note that tells the values which no axis can hold."""
    told = [
        f"{show(row[kpi_name])} ({row['planner']}, {row['scenario']})"
        for row in trials.head(MAX_TOLD).to_dict("records")
    ]
    return [f"{count(len(trials), 'value')} too large to draw: {', '.join(told)}"] if told else []


def _box(values: FloatArray, style: PlannerStyle, scale: Scale, unit: str) -> BoxRow:
    values = np.sort(values)
    low, median, high = np.percentile(values, [25, 50, 75])
    reach = 1.5 * (high - low)
    ends = values[values >= low - reach].min(), values[values <= high + reach].max()
    boxed = len(values) >= BOX_FROM
    text = f"median {show(median)} {unit}".rstrip()
    quartiles = ""
    if len(values) > 1:
        quartiles = f", quartiles {show(low)} and {show(high)}, range {show(values[0])} to {show(values[-1])}"
    return BoxRow(
        style=style,
        points=_dots(scale.place(values)),
        median=_thousandths(scale, [median])[0],
        box=_pair(scale, low, high) if boxed else None,
        whiskers=_pair(scale, *ends) if boxed else None,
        label=show(median),
        number=len(values),
        description=f"{style.name}: {text}{quartiles} ({count(len(values), 'trial')})",
    )


def _pair(scale: Scale, low: float, high: float) -> tuple[float, float]:
    places = _thousandths(scale, [low, high])
    return places[0], places[1]


def _thousandths(scale: Scale, values: Sequence[float]) -> list[float]:
    return [round(float(1000 * place), 1) for place in scale.place(np.asarray(values, dtype=float))]


def _dots(places: Iterable[float]) -> str:
    chosen = np.asarray(list(places))
    if len(chosen) > MAX_POINTS:
        chosen = chosen[np.round(np.linspace(0, len(chosen) - 1, MAX_POINTS)).astype(int)]
    spread = 220 * (len(chosen) > 2)
    heights = 500 + spread * np.sin(2.399963 * np.arange(len(chosen)))  # by the golden angle: evenly
    return "".join(f"M{1000 * x:.0f} {y:.0f}h0" for x, y in zip(chosen, heights, strict=True))
