"""Finds one trial of a run without reading the others."""

from __future__ import annotations

from pathlib import Path

from pytest_lpb.errors import LpbError, RecordingError
from pytest_lpb.names import listed, suggestion
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.trial.files import read_metadata

MAX_LISTED = 20  # trials that a message names


def find_trial(run: RunFolder, node_id: str) -> Path:
    """Path of the trial file of a node id. Raises LpbError with what there is when it is not in the run."""
    # A path says half of it, SCENARIO/PLANNER/seedK; what stands before that is a scenario's file, or a study's.
    end = node_id.split("::")[-2:]
    for path in run.trial_files():
        if [path.parent.name, path.stem] == end and _node_id(path) == node_id:
            return path
    known = {found for path in run.trial_files() if (found := _node_id(path)) is not None}
    raise LpbError(
        f"no trial {node_id!r} in this run{suggestion(node_id, known)}; "
        f"there are {listed(known) if len(known) <= MAX_LISTED else f'{len(known)} of them'}"
    )


def _node_id(path: Path) -> str | None:
    """What a trial file says it is; None for a file that cannot be read. Raw data are not read."""
    try:
        node_id = read_metadata(path).get("node_id")
    except RecordingError:
        return None
    return node_id if isinstance(node_id, str) else None
