"""Curves of a study's sweeps: a KPI over the values of one planner parameter, or of one knob of a scenario."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from pytest_lpb.names import count
from pytest_lpb.run.summary import ALL


@dataclass(frozen=True)
class Point:
    """A figure at a value: a success rate with its 95 % interval, or a median with its quartiles."""

    value: Any
    figure: float
    low: float
    high: float
    trials: str  # of a success rate: 17/22; else how many problems have a value


@dataclass(frozen=True)
class Curve:
    """A line of a sweep.

    Attributes:
        planner: whose style it is drawn in.
        label: what distinguishes it: a planner, or the other values.
        points: by value.
        family: number of the other values; a planner may have a line of each.
    """

    planner: str
    label: str
    points: Sequence[Point]
    family: int


@dataclass(frozen=True)
class Sweep:
    """One swept thing: `of` a planner or a scenario, its parameter or knob, and all variants with their values."""

    kind: str  # planners or scenarios
    of: str
    parameter: str
    variants: Mapping[str, Mapping[str, Any]]

    @property
    def values(self) -> list[Any]:
        """Values of the parameter: numbers in order, others as the study lists them."""
        chosen = [values[self.parameter] for values in self.variants.values()]
        found = list({_key(value): value for value in chosen}.values())
        return sorted(found) if all(_is_number(value) for value in found) else found

    @property
    def lines_per_planner(self) -> int:
        """How many curves a planner may have in one figure."""
        return len(self._families()) if self.kind == "scenarios" else 1

    def curves(self, summary: pd.DataFrame, column: str) -> Iterator[Curve]:
        """Curves of a figure of summary.csv, such as `success_rate` or `clearance_min_m_median`.

        A planner's curve is over the mean of all scenarios; a scenario's has a curve per planner.
        """
        for family, (others, names) in enumerate(self._families().items()):
            label = ", ".join(f"{name} {value}" for name, value in others)
            for planner, rows in self._rows(summary, names):
                points = [_point(rows[name], value, column) for name, value in names if name in rows]
                found = [point for point in points if np.isfinite(point.figure)]
                if found:
                    own = planner if self.kind == "scenarios" else ""
                    yield Curve(planner, ", ".join(filter(None, (own, label))), found, family)

    def _families(self) -> dict[tuple[tuple[str, str], ...], list[tuple[str, Any]]]:
        """Variants that differ in this parameter alone, with its values in order; by their other values."""
        order = [_key(value) for value in self.values]
        families: dict[tuple[tuple[str, str], ...], list[tuple[str, Any]]] = {}
        for name, values in self.variants.items():
            others = tuple((key, str(value)) for key, value in values.items() if key != self.parameter)
            families.setdefault(others, []).append((name, values[self.parameter]))
        for names in families.values():
            names.sort(key=lambda pair: order.index(_key(pair[1])))
        return families

    def _rows(
        self, summary: pd.DataFrame, names: Sequence[tuple[str, Any]]
    ) -> Iterator[tuple[str, dict[str, Mapping[Any, Any]]]]:
        """Rows of summary.csv by variant, for each planner that is drawn."""
        wanted = [name for name, _ in names]
        if self.kind == "planners":
            rows = summary[(summary["scenario"] == ALL) & summary["planner"].isin(wanted)]
            yield wanted[0], {str(row["planner"]): row for row in rows.to_dict("records")}
            return
        for planner, rows in summary[summary["scenario"].isin(wanted)].groupby("planner", sort=False):
            yield str(planner), {str(row["scenario"]): row for row in rows.to_dict("records")}


def sweeps_of(info: Mapping[str, Any]) -> list[Sweep]:
    """The sweeps of a run, by what run.json says: one per planner or scenario and parameter with several values."""
    found = []
    for kind, variants in (info.get("swept") or {}).items():
        bases = list(dict.fromkeys(variant["of"] for variant in variants.values()))
        for base in bases:
            own = {name: variant["values"] for name, variant in variants.items() if variant["of"] == base}
            for parameter in dict.fromkeys(key for values in own.values() for key in values):
                having = {name: values for name, values in own.items() if parameter in values}
                sweep = Sweep(kind, base, parameter, having)
                if len(sweep.values) > 1:
                    found.append(sweep)
    return found


def _point(row: Mapping[Any, Any], value: Any, column: str) -> Point:
    if column == "success_rate":
        rate, low, high = (float(row[f"success_{part}"]) for part in ("rate", "low", "high"))
        return Point(value, rate, low, high, f"{int(row['successes'])}/{int(row['trials'])}")
    stem = column.removesuffix("_median")
    low, high = (float(row.get(f"{stem}_{part}", np.nan)) for part in ("q1", "q3"))
    problems = count(int(row.get(f"{stem}_n", 0)), "problem")
    return Point(value, float(row[column]), low, high, problems)


def _key(value: Any) -> str:
    return repr(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
