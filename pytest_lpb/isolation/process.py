"""A far process as this side sees it, and how its end is told."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Mapping
from contextlib import suppress
from threading import Thread
from typing import Any, Protocol

END_S = 1.0  # [s] that a process which has left its stream has to end
OUTPUT_KEPT = 4096  # bytes of what a process prints last
CHUNK = 65536  # bytes
SPIN_S = 5e-5  # [s] that this side waits for an answer without sleeping


class FarProcess(Protocol):
    """A process that a planner runs in. `send` and `receive` raise EOFError when it has ended."""

    @property
    def about(self) -> Mapping[str, Any]:
        """Versions of what runs there."""

    def send(self, header: Mapping[str, Any], payload: bytes = b"", timeout_s: float | None = None) -> None:
        """Send a message; raises TimeoutError when it is not taken in time [s]."""

    def receive(self, timeout_s: float | None) -> tuple[dict[str, Any], bytes]:
        """The next message. Raises TimeoutError, or ValueError for what is no message."""

    def ending(self) -> str:
        """How the process ended, once it has; empty when that is not known."""

    def kill(self) -> None:
        """End it, and all of its process group."""

    def output(self) -> str:
        """The last of what it printed."""


def end_of(process: subprocess.Popen[bytes]) -> str:
    """How a process that is ending does so; empty when it has not ended in time."""
    try:
        return told(process.wait(END_S))
    except subprocess.TimeoutExpired:
        return ""


def told(code: int) -> str:
    """An exit code in words; negative ones are signals."""
    if code >= 0:
        return f"ended with exit code {code}"
    known = signal.Signals.__members__.values()
    name = next((item.name for item in known if item == -code), "a signal")
    return f"was ended by {name} (signal {-code})"


def kill_group(pid: int) -> None:
    """Kill a process group, whose leader is the process, or was."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)


class Tail:
    """Keeps the end of what is written to a descriptor, however much it is."""

    def __init__(self) -> None:
        self._kept = b""
        self._reader: Thread | None = None

    def read_from(self, descriptor: int) -> None:
        """Read in the background until nobody writes any more, then close the descriptor."""
        self._reader = Thread(target=self._read, args=(descriptor,), daemon=True)
        self._reader.start()

    def _read(self, descriptor: int) -> None:
        with suppress(OSError):
            while chunk := os.read(descriptor, CHUNK):
                self._kept = (self._kept + chunk)[-OUTPUT_KEPT:]
        os.close(descriptor)

    def join(self, timeout_s: float) -> None:
        """Wait for the end, not longer than some time [s]."""
        if self._reader is not None:
            self._reader.join(timeout_s)

    @property
    def text(self) -> str:
        """What was kept."""
        return self._kept.decode("utf-8", "replace").strip()
