"""Which timing figures other work on the same cores may have disturbed, trial by trial and KPI by KPI."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import pandas as pd

CONTENDED_KPIS = "contended_kpis"
"""Column of tables: names of the timing KPIs that are disturbed, as one text."""

SEPARATOR = "; "


class TimedKpi(Protocol):
    """What is asked of a KPI."""

    @property
    def name(self) -> str:
        """Column of trials.csv."""

    @property
    def timing(self) -> bool:
        """Whether it measures the machine as well as the planner."""


def with_contended_kpis(trials: pd.DataFrame, kpis: Sequence[TimedKpi]) -> pd.Series:
    """The column CONTENDED_KPIS; of trials without it, every timing KPI where `timing_contended` is true."""
    if CONTENDED_KPIS in trials:
        return trials[CONTENDED_KPIS].fillna("").astype(str)
    every = joined(kpi.name for kpi in kpis if kpi.timing)
    return trials["timing_contended"].eq(True).map({True: every, False: ""}).astype(str)


def contended(trials: pd.DataFrame, kpi: TimedKpi) -> pd.Series[bool]:
    """In which trials a KPI is disturbed; False for one that is no timing."""
    if not kpi.timing:
        return trials["timing_contended"].map(lambda _: False).astype(bool)
    return with_contended_kpis(trials, [kpi]).map(lambda text: kpi.name in text.split(SEPARATOR)).astype(bool)


def contended_names(rows: pd.DataFrame, keys: list[str], kpis: Sequence[TimedKpi]) -> pd.Series:
    """By group of `keys`: the KPIs that are disturbed in a trial or more, in the order of `kpis`."""
    return rows.groupby(keys)[CONTENDED_KPIS].agg(lambda texts: _union(texts, kpis)).astype(object)


def joined(names: Iterable[str]) -> str:
    """Names as CONTENDED_KPIS holds them."""
    return SEPARATOR.join(names)


def _union(texts: Iterable[str], kpis: Sequence[TimedKpi]) -> str:
    found = {name for text in set(texts) for name in text.split(SEPARATOR)}
    return joined(kpi.name for kpi in kpis if kpi.name in found)
