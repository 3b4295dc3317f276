"""Workers end with their controller, however that ends: none goes on writing into the run folder."""

from __future__ import annotations

import ctypes
import os
import signal
import sys

PR_SET_PDEATHSIG = 1  # of linux/prctl.h


def end_with_parent(controller: int) -> None:
    """Have the kernel kill this process when its parent dies; where it cannot, execnet ends it within 15 s.

    Args:
        controller: process id of the controller; a worker that it did not start itself, on another host for example,
            is left to execnet.
    """
    if sys.platform != "linux" or os.getppid() != controller:
        return
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != controller:
        # It has died meanwhile.
        os.kill(os.getpid(), signal.SIGKILL)
