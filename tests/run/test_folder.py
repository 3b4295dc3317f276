"""Run folders appear at once, also where several are made in one reports folder at the same time."""

from __future__ import annotations

import errno
import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from pytest_lpb.errors import RecordingError, StorageError
from pytest_lpb.run import crashed
from pytest_lpb.run.folder import RunFolder, new_run_folder


def test_many_at_once(tmp_path: Path) -> None:
    latest = tmp_path / "latest"

    def make(number: int) -> str:
        run = RunFolder.create(new_run_folder(tmp_path), {"number": number})
        assert latest.is_symlink()
        assert "number" in RunFolder.open(latest).info()
        return run.name

    with ThreadPoolExecutor(8) as pool:
        names = list(pool.map(make, range(200)))
    assert len(set(names)) == 200
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*names, "latest"])


def test_a_folder_that_cannot_be_made_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "rename", full)
    with pytest.raises(StorageError, match=r"cannot make .*: No space left on device; free space there"):
        RunFolder.create(new_run_folder(tmp_path), {})
    assert not list(tmp_path.iterdir())


def test_a_name_that_is_taken_is_left_alone(tmp_path: Path) -> None:
    path = new_run_folder(tmp_path)
    RunFolder.create(path, {"number": 1})
    with pytest.raises(Exception, match=r"cannot make .*: Directory not empty"):
        RunFolder.create(path, {"number": 2})
    assert RunFolder.open(path).info() == {"number": 1}


def test_a_link_that_was_left_is_not_in_the_way(tmp_path: Path) -> None:
    run = RunFolder.create(new_run_folder(tmp_path), {"started": "", "command": [], "workers": 1})
    left = tmp_path / f".latest-{run.name}-0123abcd"
    left.symlink_to(run.name)
    run.tidy()
    run.resume(run.info())
    assert not left.is_symlink()
    assert (tmp_path / "latest").is_symlink()


def test_where_latest_cannot_be_made_to_lead_nothing_is_left(tmp_path: Path) -> None:
    (tmp_path / "latest/own").mkdir(parents=True)
    with pytest.raises(RecordingError, match=r"cannot write .*latest: Is a directory"):
        RunFolder.create(new_run_folder(tmp_path), {})
    assert [path.name for path in tmp_path.iterdir()] == ["latest"]


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", b"x" * 2000, b"a\0b"])
def test_a_latest_that_is_damaged(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "latest").write_bytes(content)
    with pytest.raises(RecordingError, match=r"is no run folder|has 2000 bytes"):
        RunFolder.open(tmp_path / "latest")


def test_what_cannot_be_removed_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def read_only(*_: object, **__: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    run = RunFolder.create(new_run_folder(tmp_path), {})
    trial = run.path / "trials/x/pd/seed0.parquet"
    trial.parent.mkdir(parents=True)
    trial.touch()
    monkeypatch.setattr(crashed, "read_metadata", lambda _: {"outcome": "worker_crash"})
    monkeypatch.setattr(Path, "unlink", read_only)
    with pytest.raises(StorageError, match=r"cannot remove .*seed0.parquet: Read-only file system"):
        crashed.forget_crashes(run)
