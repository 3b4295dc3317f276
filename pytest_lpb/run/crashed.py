"""Trials whose process died: a run that is finished with workers gives them another chance."""

from __future__ import annotations

from pytest_lpb.documents.atomic import remove
from pytest_lpb.errors import RecordingError
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.trial.files import read_metadata
from pytest_lpb.trial.outcome import WORKER_CRASH


def forget_crashes(run: RunFolder) -> None:
    """Remove the files of trials that a crash cut off; none of them has raw data. Raises RecordingError.

    What killed the process may have been no fault of the planner: a person, a scheduler, too little memory.
    """
    for path in run.trial_files():
        try:
            crashed = read_metadata(path).get("outcome") == WORKER_CRASH
        except RecordingError:
            continue  # damaged: told when its trial is due
        if crashed:
            remove(path)
