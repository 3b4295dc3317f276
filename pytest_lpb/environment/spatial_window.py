"""PyBullet's window, in a process of its own.

Closing PyBullet's window, or having no display for it, ends the process that opened it (X11 asks nobody); it also
prints a lot. Here that process is not the one that runs trials: a trial goes on when its window is closed.
"""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import tempfile
from typing import Any

from pytest_lpb.environment.picture import check_display
from pytest_lpb.errors import LpbError
from pytest_lpb.problem.problem import Problem

PROGRAM = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from {module} import main; main()"
MODULE = "pytest_lpb.environment.window_process"
READY = "ready"
FAULT = "Traceback (most recent call last)"
CLOSE_S = 10.0  # [s] that the process has to end


class SpatialWindow:
    """A window that shows one problem at a time. Raises LpbError when it cannot be opened."""

    def __init__(self) -> None:
        check_display()
        self._complaints = tempfile.TemporaryFile()  # noqa: SIM115 - closed in `close`
        self._process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM.format(module=MODULE), json.dumps(sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._complaints,
            text=True,
            encoding="utf-8",
            start_new_session=True,  # Ctrl-C is for the run
        )
        self.open = True
        if self._answer() != READY:
            self._process.wait()
            said = " ".join(self._complaints_so_far().split()[-40:])
            self.close()
            raise LpbError(
                f"--lpb-render (render_mode 'human') cannot open PyBullet's window: {said or 'it says nothing'}; it "
                "needs a display with OpenGL 3 (Debian: libgl1, libgl1-mesa-dri)"
            )

    def load(self, problem: Problem) -> None:
        """Show another problem, or the same from its start."""
        self._tell({"problem": problem.to_dict(), "name": problem.name})

    def show(self, t: float, q: list[float]) -> None:
        """Show the robot at q (dof,) and everything else at the time t [s]. Returns when that is on its way."""
        self._tell({"t": t, "q": q})

    def _tell(self, message: dict[str, Any]) -> None:
        """Have the window do something, unless it was closed. Raises LpbError when it fails."""
        if not self.open:
            return
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(f"{json.dumps(message)}\n")
            self._process.stdin.flush()
            self.open = self._answer() == READY
        except OSError:
            self.open = False
        if not self.open:
            # Whoever closes the window only ends its process; what raised there is told.
            self._process.wait()
            said = self._complaints_so_far()
            if FAULT in said:
                raise LpbError(f"PyBullet's window failed: {said.strip().splitlines()[-1]}")

    def _answer(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip()

    def _complaints_so_far(self) -> str:
        self._complaints.seek(0)
        return self._complaints.read().decode(errors="replace")

    def close(self) -> None:
        """Close the window; again is no harm."""
        self.open = False
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with contextlib.suppress(OSError):
            self._process.stdin.close()  # the process ends when nobody can tell it anything any more
        try:
            self._process.wait(CLOSE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
        self._complaints.close()
