"""One process at a time runs the trials of a run folder."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pytest_lpb.errors import RecordingError
from pytest_lpb.run.lock import RunLock

pytest.importorskip("fcntl")
HOLD = """
import pathlib, sys
from pytest_lpb.run.lock import RunLock
lock = RunLock()
lock.take(pathlib.Path(sys.argv[1]))
print(lock.held, flush=True)
sys.stdin.read()
"""


def test_a_claim_holds_until_it_is_given_free(tmp_path: Path) -> None:
    first, second = RunLock(), RunLock()
    first.take(tmp_path)
    with pytest.raises(RecordingError, match="is being run by another process: wait until that has ended"):
        second.take(tmp_path)
    assert (first.held, second.held) == (True, False)
    first.release()
    second.take(tmp_path)
    assert (first.held, second.held) == (False, True)
    second.release()
    assert not list(tmp_path.iterdir())


def test_a_claim_ends_with_its_process_however_that_ends(tmp_path: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "True\n"
        lock = RunLock()
        with pytest.raises(RecordingError):
            lock.take(tmp_path)
        process.kill()
        process.wait()
        lock.take(tmp_path)
        assert lock.held
        lock.release()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes that are forked")
def test_what_a_planner_forked_does_not_hold_the_run(tmp_path: Path) -> None:
    lock, other = RunLock(), RunLock()
    lock.take(tmp_path)
    begun, end = os.pipe(), os.pipe()
    child = os.fork()
    if child == 0:
        os.write(begun[1], b"x")
        os.read(end[0], 1)
        os._exit(0)
    os.read(begun[0], 1)
    lock.release()
    try:
        other.take(tmp_path)
        assert other.held
    finally:
        os.write(end[1], b"x")
        os.waitpid(child, 0)
        other.release()


def test_where_there_are_no_locks_the_run_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise OSError(37, "No locks available")

    monkeypatch.setattr("pytest_lpb.run.lock.fcntl.flock", refused)
    lock = RunLock()
    lock.take(tmp_path)
    assert not lock.held


def test_who_closes_all_descriptors_ends_no_run(tmp_path: Path) -> None:
    lock = RunLock()
    lock.take(tmp_path)
    assert lock._descriptor is not None
    os.close(lock._descriptor)
    lock.release()
    assert not lock.held
