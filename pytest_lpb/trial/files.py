"""Trial files: raw data as Parquet and the concrete problem as a scenario file; both appear at once, whole or not.

Layout below a run folder: trials/SCENARIO/PLANNER/seedK.parquet and seedK.yaml, and assets/ with the files that
problems name; a trial file names them relative to the run folder.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
import pyarrow.parquet

from pytest_lpb.documents.atomic import write_once
from pytest_lpb.errors import LpbError, RecordingError
from pytest_lpb.problem.hashing import canonical_json
from pytest_lpb.problem.problem import Problem
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.assets import recorded, restored
from pytest_lpb.trial.units import unit_of

METADATA_KEY = b"pytest_lpb"

# What a trial can have: a million steps, bodies and obstacles as scenario files allow them.
MAX_ROWS = 1_000_001
MAX_COLUMNS = 20_000
MAX_VALUES = 500_000_000
MAX_BYTES = 8 * MAX_VALUES  # read, not as they are in the file


def trial_path(folder: Path, scenario: str, planner: str, seed: int) -> Path:
    """Path of a trial's Parquet file in a run folder."""
    return folder / "trials" / scenario / planner / f"seed{seed}.parquet"


def write_trial(folder: Path, trajectory: Trajectory) -> Path:
    """Write a trial into a run folder, unless an earlier attempt of the trial is there: the first counts.

    Raises RecordingError when it cannot be written.
    """
    metadata = trajectory.metadata
    path = trial_path(folder, metadata["scenario"], metadata["planner"], metadata["seed"])
    return write_once(path, _parquet(trajectory, recorded(trajectory.problem.to_dict(), folder)))


def _parquet(trajectory: Trajectory, problem: Mapping[str, Any]) -> bytes:
    """A trial as Parquet: zstd, floats split into byte streams, units, provenance and problem in the metadata."""
    texts: list[str] = []
    numbers: list[str] = []
    arrays, fields = [], []
    for name, values in trajectory.columns.items():
        is_text = values.dtype == object
        kind = pyarrow.string() if is_text else pyarrow.float64()
        (texts if is_text else numbers).append(name)
        arrays.append(pyarrow.array(values, kind))
        fields.append(pyarrow.field(name, kind, metadata={"unit": unit_of(name, trajectory.problem)}))
    metadata = {**trajectory.metadata, "problem": problem}
    schema = pyarrow.schema(fields, metadata={METADATA_KEY: canonical_json(metadata)})
    sink = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(
        pyarrow.Table.from_arrays(arrays, schema=schema),
        sink,
        compression="zstd",
        use_dictionary=texts,
        use_byte_stream_split=numbers,
        write_statistics=False,
    )
    content: bytes = sink.getvalue().to_pybytes()
    return content


def read_trial(path: Path) -> Trajectory:
    """Read a trial's raw data. Raises RecordingError for a file that is not one."""
    try:
        # Not `read_table`: looking for a data set of many files costs more than reading one.
        _check_regular(path)
        with pyarrow.parquet.ParquetFile(path) as file:
            _check_size(file.metadata, path)
            table = file.read(use_threads=False)
    except (OSError, pyarrow.ArrowException) as error:
        raise RecordingError(f"cannot read {path}: {error}") from error
    metadata = trial_metadata(table.schema.metadata, path)
    columns = {name: _array(name, table.column(name), path) for name in table.column_names}
    try:
        entry = restored(metadata.pop("problem"), _run_folder(path, metadata))
        problem = Problem.from_dict(entry, metadata["scenario"])
    except RecordingError as error:
        raise RecordingError(f"cannot read {path}: {error}") from error
    except (LpbError, KeyError, TypeError, ValueError) as error:
        raise RecordingError(f"cannot read {path}: its problem is not one of this version: {error!r}") from error
    return Trajectory(columns, metadata, problem)


def _run_folder(path: Path, metadata: Mapping[str, Any]) -> Path:
    """The run folder that a trial file lies in; for one that was taken out of its folders, the folder it is in."""
    inside = trial_path(Path(), metadata["scenario"], metadata["planner"], metadata["seed"])
    folders = path.absolute().parents
    depth = len(inside.parts)
    return folders[depth - 1] if path.absolute().parts[-depth:] == inside.parts else folders[0]


def read_metadata(path: Path) -> dict[str, Any]:
    """What a trial file says of itself, without its raw data. Raises RecordingError for a file that is not one."""
    try:
        _check_regular(path)
        metadata = pyarrow.parquet.read_schema(path).metadata
    except (OSError, pyarrow.ArrowException) as error:
        raise RecordingError(f"cannot read {path}: {error}") from error
    return trial_metadata(metadata, path)


def trial_metadata(metadata: Mapping[bytes, bytes] | None, path: Path) -> dict[str, Any]:
    """What a trial file says of itself, and its problem. Raises RecordingError for another kind of file."""
    if not metadata or METADATA_KEY not in metadata:
        raise RecordingError(f"{path} is no trial file of pytest-lpb: it has no metadata of ours")
    try:
        content: dict[str, Any] = json.loads(metadata[METADATA_KEY])
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"cannot read {path}: its metadata are damaged: {error}") from error
    if not isinstance(content, dict):
        raise RecordingError(f"cannot read {path}: its metadata are damaged: no mapping")
    return content


def _check_regular(path: Path) -> None:
    """Raise RecordingError for a pipe, which would be waited for, a device or a folder."""
    if path.exists() and not path.is_file():
        raise RecordingError(f"cannot read {path}: it is no regular file")


def _check_size(told: Any, path: Path) -> None:
    """Raise RecordingError for more than a trial can have: few bytes may stand for very many rows."""
    for found, most, what in (
        (told.num_rows, MAX_ROWS, "rows"),
        (told.num_columns, MAX_COLUMNS, "columns"),
        (told.num_rows * told.num_columns, MAX_VALUES, "values"),
        (sum(told.row_group(index).total_byte_size for index in range(told.num_row_groups)), MAX_BYTES, "bytes"),
    ):
        if found > most:
            raise RecordingError(f"cannot read {path}: it has {found} {what}; a trial has at most {most}")


def _array(name: str, column: Any, path: Path) -> np.ndarray[Any, Any]:
    if not (pyarrow.types.is_floating(column.type) or pyarrow.types.is_string(column.type)):
        raise RecordingError(f"cannot read {path}: its column {name!r} holds {column.type}; numbers or text are needed")
    values = column.to_numpy()
    return values if values.dtype == object else np.ascontiguousarray(values, dtype=np.float64)
