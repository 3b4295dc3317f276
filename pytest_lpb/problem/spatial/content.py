"""What is in a file, as a digest: equal digests, equal bytes, whatever the file is called and whenever it was written.

All that is kept of files within a process is kept by digest, so that an edited mesh is a new one even where its size
and time are the old ones.
"""

from __future__ import annotations

import hashlib
import os
import time
from functools import lru_cache
from pathlib import Path

from pytest_lpb.bounded import read_bounded, regular_file
from pytest_lpb.errors import ScenarioError

SETTLED_NS = 2_000_000_000  # [ns] file systems may give equal times to changes that are closer than this


def file_digest(path: Path) -> str:
    """SHA-256 of a file's bytes, in hexadecimal. Raises OSError.

    A file is read once as long as the file system says that nothing has changed, which includes the time of the last
    change of its status: no program can set that one back. Files changed a moment ago are read each time, as Git does,
    since the next change may have the same time.
    """
    stat = path.stat()
    age = time.time_ns() - max(stat.st_mtime_ns, stat.st_ctime_ns)
    if age < SETTLED_NS or os.name == "nt":  # there, st_ctime is the time of creation
        return _digest(path)
    return _settled(path, stat.st_dev, stat.st_ino, stat.st_size, stat.st_mtime_ns, stat.st_ctime_ns)


def bounded_digest(path: Path, most: int) -> str:
    """The same of a file of at most `most` bytes. Raises ScenarioError for a larger one, or one that cannot be read."""
    try:
        if regular_file(path, ScenarioError).st_size <= most:
            return file_digest(path)
    except OSError:
        pass  # and say why
    return hashlib.sha256(read_bounded(path, most, ScenarioError)).hexdigest()


@lru_cache(maxsize=1024)
def _settled(path: Path, *_status: int) -> str:
    return _digest(path)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
