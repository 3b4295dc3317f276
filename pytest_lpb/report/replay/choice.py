"""Which trials have a replay: the page must stay small, and raw data be read in seconds."""

from __future__ import annotations

import pandas as pd

from pytest_lpb.report.scenes import representative

MAX_REPLAYS = 240


def in_order_of_interest(trials: pd.DataFrame) -> pd.DataFrame:
    """Trials that moved, the most wanted first, at most `MAX_REPLAYS`.

    First of each scenario what its picture shows, then failures with the other planners on the same problem, then
    the rest; within each the lowest seeds of all scenarios first.
    """
    moved = trials[trials["steps"] > 0]
    if moved.empty:
        return moved
    shown = [representative(rows).index for _, rows in moved.groupby("scenario", sort=False)]
    problems = pd.MultiIndex.from_frame(moved[["scenario", "seed"]])
    failed = problems[~moved["success"].eq(True)]
    rank = pd.Series(2, index=moved.index).mask(problems.isin(failed), 1)
    rank[[label for labels in shown for label in labels]] = 0
    order = moved.assign(rank=rank).sort_values(["rank", "seed"], kind="stable")
    return order.drop(columns="rank").head(MAX_REPLAYS)
