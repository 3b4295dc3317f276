"""The tables of a run, and how they are written: the same table is the same bytes."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.run.aggregates import aggregates_table
from pytest_lpb.run.comparisons import comparisons_table
from pytest_lpb.run.problems import KpiColumn
from pytest_lpb.run.summary import summary_table

__all__ = ["KpiColumn", "aggregates_table", "comparisons_table", "summary_table", "write_csv"]


def write_csv(frame: pd.DataFrame, path: Path) -> None:
    r"""Write a table as UTF-8 CSV, without its index; it appears at once, whole.

    Numbers are the shortest text that reads back as the same float64; NaN and None are empty cells; booleans
    are true and false; lines end in "\n" on every platform. Raises RecordingError when it cannot be written.
    """
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(frame.columns)
    writer.writerows(_rows(frame))
    replace_file(path, stream.getvalue().encode())


def _rows(frame: pd.DataFrame) -> Iterable[tuple[str, ...]]:
    columns = [[_cell(value) for value in frame[name].tolist()] for name in frame.columns]
    return zip(*columns, strict=True)


def _cell(value: object) -> str:
    """Text of one cell."""
    if value is None or value is pd.NA or value is pd.NaT:
        return ""
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, float | np.floating):
        return "" if math.isnan(value) else repr(float(value))
    return str(value)
