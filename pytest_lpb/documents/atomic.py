"""Files that appear at once, whole or not at all, and as readable as the umask says."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path

from pytest_lpb.errors import RecordingError


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


@contextlib.contextmanager
def _temporary(path: Path, content: bytes) -> Iterator[Path]:
    """A hidden file with the content beside `path`; gone at the end. OSError becomes RecordingError."""
    temporary = path.with_name(f".{path.name}-{secrets.token_hex(4)}.part")
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
        raise RecordingError(f"cannot write {path}: {error.strerror or error}") from error


def _link_or_rename(temporary: Path, path: Path) -> None:
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise
    except OSError:
        # File systems without hard links: the existence check is not atomic there, the rename is.
        if not path.exists():
            temporary.replace(path)
