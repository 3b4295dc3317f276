"""Baseline files: what trials of some planners gave, small enough to be committed beside the planner.

JSON, one line per trial, so that a diff shows which problems changed; the same run gives the same bytes.
"""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_lpb.bounded import read_bounded
from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.errors import ConfigurationError, RecordingError
from pytest_lpb.kpis.definition import Kpi
from pytest_lpb.run.contention import contended
from pytest_lpb.run.evaluation import Evaluation

if TYPE_CHECKING:
    import pandas as pd

MAX_BYTES = 100_000_000
KIND = "pytest-lpb baseline"
SCHEMA_VERSION = 1
DIGITS = 6  # significant ones of a value: wrong by 5e-6 of it at most, far below any margin
HASH_DIGITS = 16  # of a problem's hash: 64 bits tell problems apart
KEYS = ("scenario", "seed", "problem_hash", "success", "duration_s")
CONTENDED = "timing_contended"
ALLOWED = {str: "text", int: "a whole number", bool: "true or false"}  # in words


def rounded(value: float) -> float | None:
    """A value as baselines hold it; None for NaN. The gate rounds both sides, so equal values stay equal."""
    return None if math.isnan(value) else float(f"{value:.{DIGITS}g}")


def saved_kpis(evaluation: Evaluation, names: Collection[str] | None = None) -> list[Kpi]:
    """KPIs that a baseline holds: those named; by default those that can be judged anywhere.

    That is, with values and a direction, and no timing: it is the machine's as well as the planner's.
    """
    if names is not None:
        return [kpi for kpi in evaluation.kpis if kpi.name in names]
    known = evaluation.trials.notna().any()
    return [kpi for kpi in evaluation.kpis if kpi.direction != "none" and not kpi.timing and known[kpi.name]]


def save_baseline(evaluation: Evaluation, path: Path, kpis: Sequence[Kpi]) -> Path:
    """Write the trials of an evaluated run as a baseline file; an old one is replaced.

    Raises:
        ConfigurationError: the run has no trials.
        RecordingError: it cannot be written.
    """
    trials, info = evaluation.trials, evaluation.run.info()
    if trials.empty:
        raise ConfigurationError("the run has no trials to save as a baseline")
    contended = [CONTENDED] if any(kpi.timing for kpi in kpis) else []
    columns = [*KEYS, *contended, *(kpi.name for kpi in kpis)]
    planners = {}
    for planner, rows in trials.groupby("planner", sort=True):
        about = info.get("planners", {}).get(planner, {})
        planners[str(planner)] = {
            "parameters_hash": about.get("parameters_hash"),
            "source_hash": about.get("source_hash"),
            "trials": [_line(row, columns) for row in _with_contention(rows, kpis).to_dict("records")],
        }
    head = {
        "kind": KIND,
        "schema_version": SCHEMA_VERSION,
        "git": info.get("git"),
        "machine": info.get("machine"),
        "packages": info.get("packages"),
        "columns": columns,
    }
    return replace_file(path, "".join(_text({**head, "planners": planners})).encode())


def _with_contention(rows: pd.DataFrame, kpis: Sequence[Kpi]) -> pd.DataFrame:
    """Trials in order; `timing_contended` also where one of the saved timing KPIs alone is disturbed."""
    disturbed = rows[CONTENDED].eq(True)
    for kpi in kpis:
        disturbed |= contended(rows, kpi)
    return rows.assign(**{CONTENDED: disturbed}).sort_values(["scenario", "seed"])


def _line(row: Mapping[Any, Any], columns: Sequence[str]) -> list[Any]:
    return [_cell(name, row[name]) for name in columns]


def _cell(name: str, value: Any) -> Any:
    match name:
        case "scenario":
            return str(value)
        case "seed":
            return int(value)
        case "problem_hash":
            return short_hash(value)
        case "success" | "timing_contended":
            return bool(value)
    return rounded(float(value))


def short_hash(value: Any) -> str:
    """A problem's hash as baselines hold it; empty where a crashed worker left none."""
    return value[:HASH_DIGITS] if isinstance(value, str) else ""


def _text(content: Mapping[str, Any]) -> Iterator[str]:
    """JSON with one trial per line: `json.dumps` would give each cell a line, or all trials one."""
    planners = content["planners"]
    head = json.dumps({key: value for key, value in content.items() if key != "planners"}, indent=1, allow_nan=False)
    yield head.removesuffix("\n}") + ',\n "planners": {'
    for index, (name, planner) in enumerate(planners.items()):
        yield ("," if index else "") + f"\n  {json.dumps(name)}: {{\n"
        for key in ("parameters_hash", "source_hash"):
            yield f"   {json.dumps(key)}: {json.dumps(planner[key])},\n"
        lines = (f"    {json.dumps(line, allow_nan=False)}" for line in planner["trials"])
        yield '   "trials": [\n' + ",\n".join(lines) + "\n   ]\n  }"
    yield "\n }\n}\n"


def read_baseline(path: Path) -> dict[str, Any]:
    """The content of a baseline file. Raises RecordingError for any other file, with what is wrong."""
    text = read_bounded(path, MAX_BYTES, RecordingError)
    try:
        content: dict[str, Any] = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"{path} is no baseline: it is no JSON: {error}") from error
    if not isinstance(content, dict) or content.get("kind") != KIND:
        raise RecordingError(f"{path} is no baseline: it has no {KIND!r} as its `kind`; write one with --save-baseline")
    if content.get("schema_version") != SCHEMA_VERSION:
        raise RecordingError(
            f"{path}: schema_version is {content.get('schema_version')!r}; this version reads {SCHEMA_VERSION}: "
            "save the baseline again"
        )
    try:
        _check(content)
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise RecordingError(f"{path} is damaged: {error}; save the baseline again") from error
    return content


def _check(content: Mapping[str, Any]) -> None:
    columns = content["columns"]
    if not isinstance(content.get("machine"), Mapping | None):
        raise ValueError(f"machine is {content['machine']!r}; allowed is what describes one, or null")
    missing = [name for name in KEYS if name not in columns]
    if missing:
        raise ValueError(f"columns lack {', '.join(missing)}")
    for name, planner in content["planners"].items():
        seen = set()
        for index, line in enumerate(planner["trials"]):
            if len(line) != len(columns):
                raise ValueError(f"trial {index} of {name} has {len(line)} cells; columns has {len(columns)}")
            row = dict(zip(columns, line, strict=True))
            if (row["scenario"], row["seed"]) in seen:
                raise ValueError(f"{name} has {row['scenario']} seed{row['seed']} twice")
            seen.add((row["scenario"], row["seed"]))
            _check_trial(row, f"{name}, {row['scenario']} seed{row['seed']}")


def _check_trial(row: Mapping[str, Any], where: str) -> None:
    """Raise ValueError for cells that `_cell` would not have written."""
    for key, kind in (("scenario", str), ("seed", int), ("problem_hash", str), ("success", bool)):
        if type(row[key]) is not kind:
            raise ValueError(f"{where}: {key} is {row[key]!r}; allowed is {ALLOWED[kind]}")
    for value in (value for key, value in row.items() if key not in KEYS or key == "duration_s"):
        if value is not None and not (isinstance(value, bool | int | float) and math.isfinite(value)):
            raise ValueError(f"{where}: a value is no number")


def baseline_frame(content: Mapping[str, Any], planner: str) -> pd.DataFrame:
    """Trials of one planner of a baseline file, a row each."""
    import pandas as pd  # imported late: a run is not to wait for it at its start

    frame = pd.DataFrame(content["planners"][planner]["trials"], columns=content["columns"])
    return frame if CONTENDED in frame else frame.assign(**{CONTENDED: False})
