"""A display without a screen, for windows."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

import pytest


@contextmanager
def virtual_display() -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """An X server's display name and process; the test is skipped without Xvfb, but not in CI."""
    if shutil.which("Xvfb") is None:
        message = "Xvfb is not installed"
        if os.environ.get("CI"):
            pytest.fail(f"{message}: CI must run these tests")
        pytest.skip(message)
    command = ["Xvfb", "-displayfd", "1", "-screen", "0", "1000x760x24", "-nolisten", "tcp"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as server:
        assert server.stdout is not None
        try:
            yield f":{server.stdout.readline().decode().strip()}", server
        finally:
            server.terminate()
