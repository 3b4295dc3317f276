"""Files of JSON in run folders, or beside them, that keep a reader waiting or go too deep."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_lpb.errors import RecordingError
from pytest_lpb.fairness.result import FAIRNESS_FILE, read_fairness
from pytest_lpb.retime.result import RETIMED_FILE, read_retimed
from pytest_lpb.run.baseline_file import read_baseline
from pytest_lpb.run.run_file import read_run_file

READERS: dict[str, Callable[[Path], object]] = {
    FAIRNESS_FILE: lambda path: read_fairness(path.parent),
    RETIMED_FILE: read_retimed,
    "baseline.json": read_baseline,
    "run.json": read_run_file,
}


@pytest.mark.parametrize("name", READERS)
def test_they_are_refused(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text("[" * 200_000)
    with pytest.raises(RecordingError, match=name):
        READERS[name](path)
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(RecordingError, match="is no regular file"):
        READERS[name](path)
