"""What happens in the controller when a worker is gone, and in a worker when the controller is."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from pytest_lpb.errors import StorageError
from pytest_lpb.plugin import crashes
from pytest_lpb.plugin.crashes import CrashPlugin

# A process that starts another, which ends with it, and says which.
PARENT = """
import os, subprocess, sys
code = "import os, sys, time; from pytest_lpb.run.orphans import end_with_parent; " \\
    "end_with_parent(int(sys.argv[1])); print(os.getpid(), flush=True); time.sleep(60)"
subprocess.run([sys.executable, "-c", code, str(os.getpid())])
"""


def test_a_crash_that_cannot_be_recorded_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise StorageError("cannot write x: No space left on device")

    told: list[str] = []
    monkeypatch.setattr(crashes, "write_crash", full)
    session: object = object()
    CrashPlugin(session, told.append).pytest_handlecrashitem("x.yaml::pd::seed0")  # type: ignore[arg-type]
    assert told == [
        "the process that ran x.yaml::pd::seed0 died, and this cannot be recorded: "
        "cannot write x: No space left on device"
    ]


@pytest.mark.skipif(sys.platform != "linux", reason="a promise of Linux")
def test_a_process_ends_with_its_parent() -> None:
    with subprocess.Popen([sys.executable, "-c", PARENT], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        os.kill(parent.pid, signal.SIGKILL)
        started = time.monotonic()
        # The pipe ends with the last process that holds it.
        assert parent.stdout.read() == ""
        assert time.monotonic() - started < 30.0
    assert child > 0
