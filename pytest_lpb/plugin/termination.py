"""Ctrl-C and SIGTERM end a run in the same way: finished trials are kept, tables and report are written."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Generator, Iterator
from types import FrameType
from typing import Any

import pytest


class TerminationPlugin:
    """Turns SIGTERM into a KeyboardInterrupt while a session is on; a second SIGTERM ends the process."""

    def __init__(self) -> None:
        self._session: pytest.Session | None = None
        self._replaced: dict[int, Any] = {}
        self._ending = False  # the session ends anyway
        self._waiting = False  # a signal came that interrupts what can be interrupted next

    def pytest_sessionstart(self, session: pytest.Session) -> None:
        """Listen, unless somebody else does or this is no main thread."""
        self._session = session
        if threading.current_thread() is not threading.main_thread():
            return
        for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGTERM, signal.SIG_DFL)):
            if signal.getsignal(number) is usual:
                self._replaced[number] = signal.signal(number, self._interrupt)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_sessionfinish(self) -> Generator[None, object, object]:
        """From here on the first signal waits for what is `interruptible`, the second does what it does elsewhere."""
        self._ending = True
        return (yield)

    @contextlib.contextmanager
    def interruptible(self) -> Iterator[None]:
        """Signals raise KeyboardInterrupt within, at the end of a session too; at once, if one is waiting."""
        before, self._ending = self._ending, False
        try:
            if self._waiting:
                raise KeyboardInterrupt
            yield
        finally:
            self._ending = before

    def pytest_unconfigure(self) -> None:
        """Leave the signals as they were."""
        for number in self._replaced:
            self._restore(number)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002 - signal's signature
        if self._ending:
            self._waiting = True
            self._restore(number)  # who insists ends the process
            return
        if self._session is not None:
            # Code that is interrupted may swallow the exception (a C extension, a destructor): no further trial then.
            self._session.shouldstop = "interrupted"
        if number == signal.SIGTERM:
            self._restore(number)
        raise KeyboardInterrupt

    def _restore(self, number: int) -> None:
        # More than once, perhaps: a trial that was interrupted puts back the handlers that it began with.
        signal.signal(number, self._replaced[number])
