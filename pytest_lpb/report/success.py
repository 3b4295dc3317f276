"""Success in words: trials solved first, then the rate, under the name of the mean that it is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pytest_lpb.report.numbers import EMPTY, finite, interval, percent

RATE = "success rate"
Row = Mapping[Any, Any]  # of summary.csv


def solved(row: Row) -> str:
    """`17/22`: successful trials of all that were run."""
    return f"{int(row['successes'])}/{int(row['trials'])}"


def solved_share(row: Row) -> float:
    """Share of trials solved; 0 without trials."""
    return int(row["successes"]) / max(int(row["trials"]), 1)


def rate_name(row: Row) -> str:
    """`mean of 3 scenarios`, `mean of 4 problems`; `success rate` where that is successes over trials."""
    name = str(row["success_rate_is"])
    return RATE if name.endswith(("problem", "problems")) and row["problems"] == row["trials"] else name


def common_rate_name(rows: Iterable[Row]) -> str:
    """The name of the rates of several rows: theirs where all agree, else one that leaves the number open."""
    names = {rate_name(row) for row in rows}
    if len(names) <= 1:
        return next(iter(names), RATE)
    return "mean of scenarios" if any("scenario" in name for name in names) else "mean of problems"


def named_rate(row: Row) -> str:
    """`mean of 3 scenarios: 61 %`; the rate alone where it is successes over trials."""
    name = rate_name(row)
    rate = percent(row["success_rate"])
    return rate if name == RATE else f"{name}: {rate}"


def rate_interval(row: Row) -> str:
    """The rate's 95 % interval, such as `62–88 %`."""
    return interval(row.get("success_low"), row.get("success_high"))


def success_text(row: Row) -> str:
    """All of it: `17/22 · mean of 3 scenarios: 61 % (45–76 %)`."""
    if finite(row["success_rate"]) is None:
        return EMPTY
    return f"{solved(row)} · {named_rate(row)} ({rate_interval(row)})"
