"""Files appear whole or not at all."""

import errno
import os
import stat
import sys
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.documents.atomic import remove_unfinished, replace_file, unfinished, write_once
from pytest_lpb.errors import RecordingError, StorageError

WRITERS = pytest.mark.parametrize("write", [write_once, replace_file])


@WRITERS
@pytest.mark.skipif(sys.platform == "win32", reason="file modes")
@pytest.mark.parametrize("umask", [0o022, 0o077, 0o002])
def test_a_file_is_as_readable_as_the_umask_says(tmp_path: Path, write: Any, umask: int) -> None:
    before = os.umask(umask)
    try:
        path = write(tmp_path / "a" / "b.txt", b"content")
    finally:
        os.umask(before)
    assert path.read_bytes() == b"content"
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~umask
    assert list(path.parent.iterdir()) == [path]


def test_the_first_writer_wins_or_the_last(tmp_path: Path) -> None:
    for write in (write_once, replace_file):
        for content in (b"first", b"last"):
            write(tmp_path / write.__name__, content)
    assert (tmp_path / "write_once").read_bytes() == b"first"
    assert (tmp_path / "replace_file").read_bytes() == b"last"
    assert len(list(tmp_path.iterdir())) == 2


def test_without_hard_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: Any) -> None:
        raise OSError("operation not supported")

    monkeypatch.setattr("pytest_lpb.documents.atomic.os.link", refused)
    path = tmp_path / "x.bin"
    write_once(path, b"first")
    write_once(path, b"second")
    assert path.read_bytes() == b"first"
    assert list(tmp_path.iterdir()) == [path]


def test_the_unfinished_file_is_hidden_and_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[str] = []

    def stopped(self: Path, target: Path) -> None:
        seen.append(self.name)
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "replace", stopped)
    with pytest.raises(KeyboardInterrupt):
        replace_file(tmp_path / "x.csv", b"content")
    assert seen[0].startswith(".x.csv-")
    assert seen[0].endswith(".part")
    assert not list(tmp_path.iterdir())


@WRITERS
def test_what_cannot_be_written_is_named_with_the_reason(tmp_path: Path, write: Any) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with pytest.raises(RecordingError, match=r"cannot write .*x\.csv: (File exists|Not a directory)"):
        write(tmp_path / "file" / "x.csv", b"")


def test_a_folder_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "x.csv").mkdir()
    with pytest.raises(RecordingError, match=r"cannot write .*x\.csv: "):
        replace_file(tmp_path / "x.csv", b"")
    assert [path.name for path in tmp_path.iterdir()] == ["x.csv"]


@WRITERS
@pytest.mark.parametrize("step", ["mkdir", "open", "rename"])
@pytest.mark.parametrize(
    ("code", "kind", "advice"),
    [(errno.ENOSPC, StorageError, "; free space there"), (errno.EFBIG, RecordingError, "File too large$")],
)
def test_a_disk_that_takes_no_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Any, step: str, code: int, kind: type, advice: str
) -> None:
    def refused(*_: Any, **__: Any) -> None:
        raise OSError(code, os.strerror(code))

    for name in {"mkdir": ["mkdir"], "open": ["open"], "rename": ["replace"]}[step]:
        monkeypatch.setattr(Path, name, refused)
    monkeypatch.setattr("pytest_lpb.documents.atomic.os.link", refused)
    with pytest.raises(RecordingError, match=rf"cannot write .*x\.csv: .*{advice}") as caught:
        write(tmp_path / "x.csv", b"content")
    assert type(caught.value) is kind
    assert not list(tmp_path.iterdir())


@WRITERS
def test_a_file_that_is_cut_off_is_not_published(tmp_path: Path, write: Any) -> None:
    """What the operating system refuses in the middle: a limit for the size of files."""
    resource = pytest.importorskip("resource")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, limits[1]))
    try:
        with pytest.raises(RecordingError, match=r"cannot write .*x\.csv: File too large"):
            write(tmp_path / "x.csv", bytes(2_000_000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert not list(tmp_path.iterdir())


def test_what_writers_that_died_have_left_is_removed(tmp_path: Path) -> None:
    kept = write_once(tmp_path / "a/b.part", b"not hidden")
    unfinished(kept).write_bytes(b"half")
    (unfinished(tmp_path / "a/folder") / "deep").mkdir(parents=True)
    remove_unfinished(tmp_path)
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["b.part"]
    assert kept.read_bytes() == b"not hidden"
