"""Files that appear at once, whole or not at all, and as readable as the umask says.

A process that dies in the middle leaves a hidden file, which nothing reads; `remove_unfinished` takes it away.
"""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path

from pytest_lpb.errors import RecordingError, StorageError

UNFINISHED = ".*.part"  # names of files whose writer is at work, or has died
# What ends a run, since no further trial can be recorded either; with what to do.
FULL = "free space there"
STORAGE_FAULTS = {
    errno.ENOSPC: FULL,
    errno.EDQUOT: FULL,
    errno.EROFS: "the file system can only be read: mount it for writing, or choose another folder",
}


def write_once(path: Path, content: bytes) -> Path:
    """Write a file and missing folders above it, unless it exists: the first writer wins. Raises RecordingError."""
    with _temporary(path, content) as temporary, contextlib.suppress(FileExistsError):
        # A hard link fails where a file is; a rename would replace it.
        _link_or_rename(temporary, path)
    return path


def replace_file(path: Path, content: bytes) -> Path:
    """Write a file and missing folders above it, over an old one. Raises RecordingError."""
    with _temporary(path, content) as temporary:
        temporary.replace(path)
    return path


def unfinished(path: Path) -> Path:
    """A hidden name beside a path, for what is to become it."""
    return path.with_name(f".{path.name}-{secrets.token_hex(4)}.part")


@contextlib.contextmanager
def _temporary(path: Path, content: bytes) -> Iterator[Path]:
    """A hidden file with the content beside `path`; gone at the end. OSError becomes RecordingError."""
    temporary = unfinished(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            # Not tempfile.mkstemp, whose files nobody else may read whatever the umask.
            with temporary.open("xb") as file:
                file.write(content)
            yield temporary
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise recording_error(f"cannot write {path}", error) from error


def recording_error(what: str, error: OSError) -> RecordingError:
    """An error of the operating system in words: what cannot be done, why, and what to do where that is known."""
    remedy = STORAGE_FAULTS.get(error.errno or 0)
    text = f"{what}: {error.strerror or error}"
    return RecordingError(text) if remedy is None else StorageError(f"{text}; {remedy}")


def remove_unfinished(folder: Path) -> None:
    """Remove what writers that died have left below a folder. No writer may be at work there. Raises RecordingError."""
    try:
        for path in list(folder.rglob(UNFINISHED)):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)
    except OSError as error:
        raise recording_error(f"cannot tidy up {folder}", error) from error


def remove(path: Path) -> None:
    """Remove a file, if it is there. Raises RecordingError."""
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise recording_error(f"cannot remove {path}", error) from error


def _link_or_rename(temporary: Path, path: Path) -> None:
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise
    except OSError:
        # File systems without hard links: the existence check is not atomic there, the rename is.
        if not path.exists():
            temporary.replace(path)
