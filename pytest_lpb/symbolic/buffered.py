"""CasADi functions whose arguments and results stay in the same arrays from call to call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import casadi
import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import LpbError

FloatArray = NDArray[np.float64]


class BufferedFunction:
    """A CasADi function called through its buffers: no dictionaries, no conversion per call.

    Not thread safe: arrays and work memory are those of the object. Two objects of one function share neither.

    Attributes:
        arguments: by name, arrays to be filled in place, all zeros at first. A column vector (n, 1) is an array (n,);
            a matrix of n columns is an array (n, rows), a row per column of CasADi's (CasADi stores columns first).
        results: by name, arrays that a call fills.
        evaluate: what a call does, less the check that it succeeded: for functions that cannot fail, in inner loops.
    """

    def __init__(self, function: casadi.Function) -> None:
        """Bind arrays to a function's arguments and results.

        Raises:
            LpbError: an argument or a result is sparse.
        """
        inputs, outputs = function.name_in(), function.name_out()
        self.arguments = _arrays(function, "argument", inputs, function.sparsity_in)
        self.results = _arrays(function, "result", outputs, function.sparsity_out)
        self._name: str = function.name()
        self._buffer, trigger = function.buffer()
        _bind(self._buffer.set_arg, self.arguments)
        _bind(self._buffer.set_res, self.results)
        # CasADi's trigger knows memory by its address only: whoever keeps the trigger keeps the memory.
        trigger.memory = (self._buffer, self.arguments, self.results)
        self.evaluate: Callable[[], None] = trigger

    def __call__(self) -> None:
        """Fill the results from the arguments.

        Raises:
            LpbError: compiled code failed: an assertion in it does not hold, or a solver in it has no solution.
            RuntimeError: interpreted code failed; CasADi says where.
        """
        self.evaluate()
        # Interpreted code raises, compiled code does not.
        code = self._buffer.ret()
        if code:
            raise LpbError(f"evaluation of the CasADi function {self._name} failed with code {code}")


def _arrays(
    function: casadi.Function, role: str, names: list[str], sparsity: Callable[[int], Any]
) -> Mapping[str, FloatArray]:
    """Zeros for all arguments or all results; read-only, as an array put in later would not be the bound one."""
    return MappingProxyType(
        {name: np.zeros(_shape(function, role, name, sparsity(place))) for place, name in enumerate(names)}
    )


def _shape(function: casadi.Function, role: str, name: str, sparsity: Any) -> tuple[int, ...]:
    if not sparsity.is_dense():
        raise LpbError(
            f"{role} {name} of the CasADi function {function.name()} is sparse: {sparsity.nnz()} of "
            f"{sparsity.size1()} x {sparsity.size2()} entries; make it dense with casadi.densify"
        )
    rows, columns = sparsity.shape
    return (rows,) if columns == 1 else (columns, rows)


def _bind(set_buffer: Callable[..., None], arrays: Mapping[str, FloatArray]) -> None:
    for place, array in enumerate(arrays.values()):
        # Nothing is read from or written to empty ones, and memory without bytes may have no address.
        if array.size:
            set_buffer(place, array.data)
