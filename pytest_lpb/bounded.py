"""Files of strangers, read with a bound: regular files only, for pipes keep one waiting and devices have no end."""

from __future__ import annotations

import os
from pathlib import Path
from stat import S_ISREG

from pytest_lpb.errors import LpbError


def read_bounded(path: Path, most: int, kind: type[LpbError] = LpbError, called: str = "") -> bytes:
    """The bytes of a regular file.

    Args:
        path: the file.
        most: bytes it may have.
        kind: of the error.
        called: what messages call the file; default its path.

    Raises `kind`: `called: what is wrong` for what cannot be read, is no regular file, or has more bytes.
    """
    called = called or str(path)
    size = regular_file(path, kind, called).st_size
    if size > most:
        raise kind(f"{called}: has {size} bytes; allowed are {most}")
    try:
        with path.open("rb") as file:
            return file.read(most)
    except OSError as error:
        raise kind(f"{called}: cannot be read: {error.strerror or error}") from None


def regular_file(path: Path, kind: type[LpbError] = LpbError, called: str = "") -> os.stat_result:
    """What the system says of a regular file, links followed. Raises `kind` for anything else."""
    called = called or str(path)
    try:
        stat = path.stat()
    except (OSError, ValueError) as error:
        raise kind(f"{called}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not S_ISREG(stat.st_mode):
        raise kind(f"{called}: is no regular file")
    return stat
