"""Processes that run trials end with the one that the user started, however that ends: none goes on by itself."""

from __future__ import annotations

import ctypes
import os
import signal
import sys

PR_SET_PDEATHSIG = 1  # of linux/prctl.h


def end_with_parent(controller: int) -> None:
    """Have the kernel kill this process when its parent dies; where it cannot, execnet ends a worker within 15 s.

    Args:
        controller: process id of the parent; a worker that it did not start itself, on another host for example,
            is left to execnet.
    """
    if sys.platform != "linux" or os.getppid() != controller:
        return
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != controller:
        # It has died meanwhile.
        os.kill(os.getpid(), signal.SIGKILL)
