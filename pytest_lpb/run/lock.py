"""Who runs the trials of a run folder: one process at a time. The claim ends with the process, however that ends."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path

from pytest_lpb.errors import RecordingError

try:
    import fcntl
except ImportError:  # Windows has no such locks
    fcntl = None  # type: ignore[assignment]

HELD = (errno.EWOULDBLOCK, errno.EACCES)


class RunLock:
    """A claim to a run folder, on the folder itself: it leaves no file behind.

    Attributes:
        held: whether nobody else can run trials there; False where the file system has no locks, too.
    """

    def __init__(self) -> None:
        self._descriptor: int | None = None
        if hasattr(os, "register_at_fork"):
            # A process that a planner forked may outlive this one: it is not to hold the run.
            os.register_at_fork(after_in_child=self._forget)

    @property
    def held(self) -> bool:
        """Whether this process has the run to itself."""
        return self._descriptor is not None

    def take(self, folder: Path) -> None:
        """Claim a run folder. Raises RecordingError when another process runs its trials, or it cannot be opened."""
        if fcntl is None:
            return
        try:
            descriptor = os.open(folder, os.O_RDONLY)
        except OSError as error:
            raise RecordingError(f"cannot open {folder}: {error.strerror}") from error
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(descriptor)
            if error.errno in HELD:
                raise RecordingError(f"{folder} is being run by another process: wait until that has ended") from error
            # Some network file systems have no locks for folders: two runs at once are harmless, only in vain.
            return
        self._descriptor = descriptor

    def release(self) -> None:
        """Give the run folder free."""
        self._forget()

    def _forget(self) -> None:
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            # A planner that closes all descriptors it finds has closed this one.
            with suppress(OSError):
                os.close(descriptor)
