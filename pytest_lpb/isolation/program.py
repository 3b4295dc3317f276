"""A program in any language, which speaks the protocol over its standard input and output."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from pytest_lpb.errors import PlannerError
from pytest_lpb.isolation.far.stream import Stream
from pytest_lpb.isolation.process import END_S, SPIN_S, Tail, end_of, kill_group
from pytest_lpb.isolation.settings import Isolation

SUPERVISED = (sys.executable, "-I", "-S", str(Path(__file__).with_name("supervisor.py")))


class Program:
    """A started program.

    Raises PlannerError when it cannot be started.
    """

    def __init__(self, isolation: Isolation) -> None:
        self.about: Mapping[str, Any] = {}
        try:
            self._process = subprocess.Popen(
                [*SUPERVISED, str(isolation.memory_mb or 0), *isolation.command],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                bufsize=0,
                cwd=isolation.working_dir,
                env={**os.environ, **isolation.environment},
                start_new_session=True,
            )
        except OSError as error:
            raise PlannerError(f"command: cannot run {isolation.command[0]}: {error.strerror}") from None
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        os.set_blocking(self._process.stdin.fileno(), False)
        self._stream = Stream(self._process.stdout.fileno(), self._process.stdin.fileno(), self._lives, SPIN_S)
        self._tail = Tail()
        self._tail.read_from(os.dup(self._process.stderr.fileno()))
        self._process.stderr.close()

    def _lives(self) -> bool:
        return self._process.poll() is None

    def send(self, header: Mapping[str, Any], payload: bytes = b"", timeout_s: float | None = None) -> None:
        """Send a message. Raises ValueError when the program has written without being asked."""
        if self._stream.has_more():
            # What it says next would be taken for the answer to this.
            raise ValueError("it wrote more than one answer, or before it was asked")
        self._stream.send(header, payload, timeout_s)

    def receive(self, timeout_s: float | None) -> tuple[dict[str, Any], bytes]:
        """The next message."""
        return self._stream.receive(timeout_s)

    def ending(self) -> str:
        """How the process ended, once it writes no more."""
        return end_of(self._process)

    def kill(self) -> None:
        """End the process, with whatever it has started."""
        kill_group(self._process.pid)
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            with suppress(OSError):
                assert pipe is not None
                pipe.close()
        self._tail.join(END_S)

    def output(self) -> str:
        """The last of what it wrote to its standard error."""
        return self._tail.text
