"""Solves the quadratic programs, with PIQP (Schwan, Jiang, Kuhn and Jones, "PIQP: A Proximal Interior-Point Quadratic
Programming Solver", CDC 2023): of the open solvers it has the flattest tail.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import piqp

from pytest_lpb.planner.base import FloatArray
from pytest_lpb.planner.mpc.program import Program

MOST_ITERATIONS = 50
RESIDUAL = 1e-2  # of rows and bounds, above which a plan that is not solved is none


@dataclass(frozen=True)
class Solution:
    """What a solver says: the variables, whether they are a plan, and how hard it was."""

    z: FloatArray
    solved: bool
    iterations: int
    residual: float


class PiqpSolver:
    """PIQP on one program again and again; set up at the first solution, then updated.

    Args:
        program: filled in before each solution.
        tolerance: absolute and relative.
    """

    def __init__(self, program: Program, tolerance: float) -> None:
        self._program = program
        self._solver = piqp.SparseSolver()
        settings = self._solver.settings
        settings.eps_abs = settings.eps_rel = tolerance
        settings.check_duality_gap = False
        settings.preconditioner_iter = 0
        settings.max_iter = MOST_ITERATIONS
        settings.kkt_solver = piqp.KKTSolver.sparse_ldlt_cond
        self._ready = False
        self._free = np.full(len(program.low), np.inf)

    def solve(self) -> Solution:
        """Solve the program as it is filled in now."""
        p = self._program
        if self._ready:
            self._solver.update(P=p.P, c=p.c, A=p.A, b=p.b, G=p.G, h_l=p.low, x_l=p.lower, x_u=p.upper)
        else:
            self._solver.setup(p.P, p.c, p.A, p.b, p.G, p.low, self._free, p.lower, p.upper)
            self._ready = True
        status = self._solver.solve()
        result = self._solver.result
        z = np.asarray(result.x)
        residual = float(result.info.primal_res)
        solved = status == piqp.PIQP_SOLVED or (status == piqp.PIQP_MAX_ITER_REACHED and residual < RESIDUAL)
        return Solution(z, bool(solved and np.isfinite(z).all()), int(result.info.iter), residual)
