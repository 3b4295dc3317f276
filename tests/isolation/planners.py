"""Planners that take their process down, stop it, or fill it."""

from __future__ import annotations

import ctypes
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb import Planner

FAULT_AT = 0.3  # [s]


class Hostile(Planner):
    """Moves, then does what its parameter names, in the trials of its seeds; at once in setup if it says so."""

    @dataclass(frozen=True)
    class Parameters:
        fault: str = "none"
        in_setup: bool = False
        megabytes: int = 0

    def setup(self, problem: Any) -> None:
        self.trials = getattr(self, "trials", 0) + 1
        if self.parameters.in_setup:
            getattr(self, self.parameters.fault)()

    def compute_action(self, observation: Any) -> Any:
        self.diagnostics = {"trials": float(self.trials), "pid": float(os.getpid())}
        if observation["t"] >= FAULT_AT - 1e-9:
            getattr(self, self.parameters.fault)()
        return np.array([1.0, 0.0])

    def none(self) -> None:
        pass

    def hangs(self) -> None:
        time.sleep(60.0)

    def spins_in_c(self) -> None:
        """Never gives the interpreter back."""
        ctypes.PyDLL(None).usleep(60_000_000)

    def segfaults(self) -> None:
        print("about to crash")
        ctypes.string_at(0)

    def leaves(self) -> None:
        os.write(2, b"leaving for good\n")
        os._exit(7)

    def fills(self) -> None:
        self.kept = np.ones((self.parameters.megabytes, 125_000))

    def prints(self) -> None:
        print("x" * 5_000_000)
        os.write(1, b"y" * 1_000_000)
        sys.stderr.write("z" * 1_000_000)

    def forks(self) -> None:
        os.fork()

    def leaves_a_child(self) -> None:
        """What it leaves behind keeps all descriptors open."""
        child = os.fork()
        if child:
            os.write(2, b"child %d\n" % child)
            os._exit(5)
        time.sleep(60.0)

    def asks(self) -> None:
        input("yes or no?")


class BadStart(Planner):
    """Cannot be built."""

    def __init__(self, parameters: Any = None) -> None:
        raise OSError("library missing")


class Tells(Planner):
    """Its diagnostics say where it runs."""

    def compute_action(self, observation: Any) -> Any:
        self.diagnostics = {
            "pid": float(os.getpid()),
            "threads": float(os.environ.get("OMP_NUM_THREADS", "0")),
            "mine": float(os.environ.get("MINE", "0")),
            "files": float(len(list(Path.cwd().iterdir()))),
        }
        return np.array([1.0, 0.0])
