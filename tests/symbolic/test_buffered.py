"""Functions through buffers against the same functions called the ordinary way."""

from __future__ import annotations

from typing import Any

import casadi
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from pytest_lpb.errors import LpbError
from pytest_lpb.symbolic.buffered import BufferedFunction


def function_of(kind: Any) -> casadi.Function:
    """Vectors, matrices, a number and empty ones, in and out."""
    x, a, s = kind.sym("x", 3), kind.sym("A", 2, 3), kind.sym("s")
    empty, no_columns, row = kind.sym("empty", 0), kind.sym("no_columns", 3, 0), kind.sym("row", 1, 4)
    results = [a @ x, s * a, casadi.dot(x, x) + s, empty, no_columns, 2 * row]
    return casadi.Function(
        "f",
        [x, a, s, empty, no_columns, row],
        results,
        ["x", "A", "s", "empty", "no_columns", "row"],
        ["Ax", "sA", "xx", "nothing", "none", "twice"],
    )


KINDS = pytest.mark.parametrize("kind", [casadi.SX, casadi.MX])


@KINDS
def test_shapes_and_zeros_at_first(kind: Any) -> None:
    buffered = BufferedFunction(function_of(kind))
    assert {name: array.shape for name, array in buffered.arguments.items()} == {
        "x": (3,),
        "A": (3, 2),
        "s": (1,),
        "empty": (0,),
        "no_columns": (0, 3),
        "row": (4, 1),
    }
    assert {name: array.shape for name, array in buffered.results.items()} == {
        "Ax": (2,),
        "sA": (3, 2),
        "xx": (1,),
        "nothing": (0,),
        "none": (0, 3),
        "twice": (4, 1),
    }
    assert not any(array.any() for array in (*buffered.arguments.values(), *buffered.results.values()))


@KINDS
def test_values_are_those_of_an_ordinary_call(kind: Any) -> None:
    function = function_of(kind)
    buffered = BufferedFunction(function)
    generator = np.random.Generator(np.random.PCG64(3))
    for call in (buffered, buffered.evaluate):
        for array in buffered.arguments.values():
            array[...] = generator.normal(size=array.shape)
        # Casadi's matrices are the transposed ones; a vector has no transpose.
        expected = function(*(array.T for array in buffered.arguments.values()))
        call()
        for value, result in zip(expected, buffered.results.values(), strict=True):
            assert_array_equal(result, np.array(value).T.reshape(result.shape))


def test_rows_are_columns_of_casadi() -> None:
    points = casadi.SX.sym("points", 2, 3)
    buffered = BufferedFunction(casadi.Function("f", [points], [points[:, 1]], ["points"], ["second"]))
    buffered.arguments["points"][:] = [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]
    buffered()
    assert_array_equal(buffered.results["second"], [3.0, 4.0])


def test_two_of_one_function_share_nothing() -> None:
    x = casadi.SX.sym("x")
    function = casadi.Function("f", [x], [x + 1], ["x"], ["y"])
    one, other = BufferedFunction(function), BufferedFunction(function)
    one.arguments["x"][:] = 5.0
    one()
    other()
    assert (one.results["y"][0], other.results["y"][0]) == (6.0, 1.0)


def test_memory_lives_as_long_as_the_trigger() -> None:
    x = casadi.SX.sym("x", 1000)
    buffered = BufferedFunction(casadi.Function("f", [x], [2 * x], ["x"], ["y"]))
    buffered.arguments["x"][:] = 1.0
    evaluate, y = buffered.evaluate, buffered.results["y"]
    del buffered
    filler = [np.full(1000, 7.0) for _ in range(100)]  # takes the place of whatever was freed
    evaluate()
    assert_array_equal(y, np.full(1000, 2.0))
    assert_array_equal(filler, np.full((100, 1000), 7.0))


def test_arrays_cannot_be_exchanged() -> None:
    buffered = BufferedFunction(function_of(casadi.SX))
    with pytest.raises(TypeError, match="does not support item assignment"):
        buffered.arguments["x"] = np.ones(3)  # type: ignore[index]


def test_sparse_ones_are_refused() -> None:
    x = casadi.SX.sym("x", 2)
    sparse = casadi.Function("turn", [x], [casadi.diag(x)], ["x"], ["D"])
    with pytest.raises(LpbError, match=r"result D of the CasADi function turn is sparse: 2 of 2 x 2 .*casadi.densify"):
        BufferedFunction(sparse)
    a = casadi.SX.sym("A", casadi.Sparsity.lower(2))
    with pytest.raises(LpbError, match="argument A of the CasADi function f is sparse: 3 of 2 x 2 entries"):
        BufferedFunction(casadi.Function("f", [a], [x[0]], ["A"], ["y"], {"allow_free": True}))


def test_derivatives_that_are_zero_are_sparse() -> None:
    """Their densified form has zeros, which each call writes."""
    x = casadi.SX.sym("x")
    zero = casadi.jacobian(casadi.SX.sym("y", 2), x)
    with pytest.raises(LpbError, match="is sparse: 0 of 2 x 1 entries"):
        BufferedFunction(casadi.Function("f", [x], [zero], ["x"], ["J"]))
    buffered = BufferedFunction(casadi.Function("f", [x], [casadi.densify(zero)], ["x"], ["J"]))
    buffered.results["J"][:] = 9.0
    buffered()
    assert_array_equal(buffered.results["J"], [0.0, 0.0])


def test_a_function_of_nothing() -> None:
    buffered = BufferedFunction(casadi.Function("f", [], [casadi.SX(3.0)], [], ["three"]))
    buffered()
    assert dict(buffered.arguments) == {}
    assert buffered.results["three"][0] == 3.0


def test_failures_of_interpreted_code_are_raised() -> None:
    x = casadi.MX.sym("x")
    buffered = BufferedFunction(casadi.Function("f", [x], [x.attachAssert(x > 0, "not positive")], ["x"], ["y"]))
    buffered.arguments["x"][:] = 1.0
    buffered()
    buffered.arguments["x"][:] = -1.0
    with pytest.raises(RuntimeError, match="not positive"):
        buffered()
