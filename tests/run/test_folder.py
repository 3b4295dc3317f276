"""Run folders appear at once, also where several are made in one reports folder at the same time."""

from __future__ import annotations

import errno
import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from pytest_lpb.errors import StorageError
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
