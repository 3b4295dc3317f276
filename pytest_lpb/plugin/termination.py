"""SIGTERM ends a run as Ctrl-C does: finished trials are kept, tables and report are written."""

from __future__ import annotations

import signal
import threading
from types import FrameType


class TerminationPlugin:
    """Turns the first SIGTERM into a KeyboardInterrupt while a session is on; a second one ends the process."""

    def __init__(self) -> None:
        self._installed = False

    def pytest_sessionstart(self) -> None:
        """Listen, unless somebody else does or this is no main thread."""
        in_main_thread = threading.current_thread() is threading.main_thread()
        if in_main_thread and signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
            signal.signal(signal.SIGTERM, self._interrupt)
            self._installed = True

    def pytest_unconfigure(self) -> None:
        """Leave the signal as it was."""
        self._restore()

    def _interrupt(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002 - signal's signature
        self._restore()
        raise KeyboardInterrupt("terminated")

    def _restore(self) -> None:
        if self._installed:
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
            self._installed = False
