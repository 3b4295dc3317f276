"""The quadratic program of one real-time iteration, filled in place: sparsity never changes.

Variables, stage by stage: inputs a_k (n), slack s_k (1), state x_{k+1} (m). The state at the start is no variable.

    min  1/2 z' P z + c' z    with  A z = b,  G z >= low,  lower <= z <= upper
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from pytest_lpb.planner.base import FloatArray

Index = NDArray[np.intp]


@dataclass(frozen=True)
class Sizes:
    """Sizes of a program."""

    steps: int  # N
    inputs: int  # n
    states: int  # m
    dof: int  # of the states the first are q
    rows: int  # distances per step

    @property
    def block(self) -> int:
        """Variables per stage."""
        return self.inputs + 1 + self.states

    @property
    def variables(self) -> int:
        """All variables."""
        return self.steps * self.block

    def places(self, start: int, count: int) -> Index:
        """Places (N, count) of variables that begin at `start` within each stage."""
        return np.arange(self.steps)[:, None] * self.block + start + np.arange(count)

    @property
    def input_places(self) -> Index:
        """Of the inputs, (N, n)."""
        return self.places(0, self.inputs)

    @property
    def slack_places(self) -> Index:
        """Of the slacks, (N, 1)."""
        return self.places(self.inputs, 1)

    @property
    def state_places(self) -> Index:
        """Of the states after each step, (N, m)."""
        return self.places(self.inputs + 1, self.states)


class Entries:
    """A sparse matrix whose entries are given again and again in one order.

    Args:
        rows, columns: of the entries, any shape.
        shape: of the matrix.
    """

    def __init__(self, rows: Index, columns: Index, shape: tuple[int, int]) -> None:
        count = rows.size
        numbered = sparse.coo_matrix((np.arange(1, count + 1), (rows.ravel(), columns.ravel())), shape=shape).tocsc()
        self._order = numbered.data - 1
        self.matrix = sparse.csc_matrix((np.zeros(count), numbered.indices, numbered.indptr), shape=shape)

    def fill(self, values: FloatArray) -> None:
        """Fill in all entries, in the order in which their places were given."""
        self.matrix.data[:] = values.ravel()[self._order]


def dense_blocks(rows: Index, columns: Index) -> tuple[Index, Index]:
    """Rows and columns of the entries of dense blocks: of rows (N, r) and columns (N, c), (N, r, c) each."""
    shape = (*rows.shape, columns.shape[1])
    return np.broadcast_to(rows[:, :, None], shape), np.broadcast_to(columns[:, None, :], shape)


class Program:
    """A program of fixed sparsity.

    Attributes:
        sizes: its sizes.
        P, A, G: matrices (P its upper triangle) as scipy's csc_matrix; c, b, low, lower, upper: vectors.
    """

    def __init__(self, sizes: Sizes) -> None:
        self.sizes = sizes
        steps, states, total = sizes.steps, sizes.states, sizes.variables
        a, s, x = sizes.input_places, sizes.slack_places, sizes.state_places
        upper = np.triu_indices(sizes.dof)
        self._upper = upper
        rows = [a, a[:-1], s, x[:, upper[0]], x[:, sizes.dof :]]
        columns = [a, a[1:], s, x[:, upper[1]], x[:, sizes.dof :]]
        self._quadratic = Entries(_places(rows), _places(columns), (total, total))
        equal = np.arange(steps * states).reshape(steps, states)
        before = dense_blocks(equal[1:], x[:-1])
        inputs = dense_blocks(equal, a)
        self._equal = Entries(
            _places([equal, before[0], inputs[0]]), _places([x, before[1], inputs[1]]), (steps * states, total)
        )
        distances = np.arange(steps * sizes.rows).reshape(steps, sizes.rows)
        gradients = dense_blocks(distances, x[:, : sizes.dof])
        slacks = np.broadcast_to(s, distances.shape)
        self._distance = Entries(
            _places([gradients[0], distances]), _places([gradients[1], slacks]), (steps * sizes.rows, total)
        )
        self.P, self.A, self.G = self._quadratic.matrix, self._equal.matrix, self._distance.matrix
        self.c, self.b = np.zeros(total), np.zeros(steps * states)
        self.low = np.zeros(steps * sizes.rows)
        self.lower, self.upper = np.full(total, -np.inf), np.full(total, np.inf)

    def cost(self, hessians: FloatArray, gradients: FloatArray, weights: Weights, last_input: FloatArray) -> None:
        """Fill in the cost.

        Args:
            hessians, gradients: of the errors and what else is quadratic in q, (N, dof, dof) and (N, dof).
            weights: of all else.
            last_input: the one before the first, (n,).
        """
        sizes = self.sizes
        change = np.full((sizes.steps, sizes.inputs), 2.0 * weights.input_change)
        change[-1] *= 0.5
        values = [
            weights.input + change,
            np.full((sizes.steps - 1, sizes.inputs), -weights.input_change),
            np.full(sizes.steps, weights.slack_squared),
            hessians[:, self._upper[0], self._upper[1]],
            weights.velocities(sizes),
        ]
        self._quadratic.fill(_joined(values))
        self.c[:] = 0.0
        self.c[sizes.input_places[0]] = -weights.input_change * last_input
        self.c[sizes.slack_places] = weights.slack
        self.c[sizes.state_places[:, : sizes.dof]] = gradients

    def motion(self, by_state: FloatArray, by_input: FloatArray, offsets: FloatArray) -> None:
        """Fill in x_{k+1} = A_k x_k + B_k a_k + offset_k; of the first step A_0 x_0 belongs to the offset.

        Args:
            by_state: A_k for k = 1.., (N - 1, m, m).
            by_input: B_k, (N, m, n).
            offsets: (N, m).
        """
        self._equal.fill(_joined([np.ones_like(offsets), -by_state, -by_input]))
        self.b[:] = offsets.ravel()

    def distances(self, gradients: FloatArray, low: FloatArray) -> None:
        """Fill in J q_{k+1} + s_k >= low: gradients (N, rows, dof), low (N, rows)."""
        self._distance.fill(_joined([gradients, np.ones_like(low)]))
        self.low[:] = low.ravel()


@dataclass(frozen=True)
class Weights:
    """Weights of the cost but those of the errors."""

    velocity: float
    velocity_end: float
    input: float
    input_change: float
    slack: float
    slack_squared: float

    def velocities(self, sizes: Sizes) -> FloatArray:
        """Of the velocities after each step, (N, n)."""
        values = np.full((sizes.steps, sizes.states - sizes.dof), self.velocity)
        values[-1] += self.velocity_end
        return values


def _joined(parts: Sequence[FloatArray]) -> FloatArray:
    return np.concatenate([part.ravel() for part in parts])


def _places(parts: Sequence[Index]) -> Index:
    return np.concatenate([part.ravel() for part in parts])
