"""What a plan is judged by at one step of the horizon: errors of the sub-goals, distances, and their Jacobians."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from math import sqrt
from typing import Any

import casadi

from pytest_lpb.planner.base import GoalInfo
from pytest_lpb.planner.mpc.parameters import MpcParameters
from pytest_lpb.planner.scene.goals import ERRORS
from pytest_lpb.planner.scene.layout import Slot
from pytest_lpb.planner.scene.maps import State
from pytest_lpb.planner.scene.parts import Ball, ends_of
from pytest_lpb.planner.scene.robot_parts import balls_of
from pytest_lpb.planner.scene.segments import segment_derivatives
from pytest_lpb.planner.scene.self_collision import pairs_of
from pytest_lpb.planner.scene.shapes import MESH
from pytest_lpb.problem.robot import Robot

ABSENT_M = 1e3  # [m] added to distances to slots without an obstacle

Row = tuple[Any, Any]  # a distance (1, 1) and its gradient (1, k)


class Stage:
    """One step of the horizon, symbolic.

    Args:
        robot: any robot.
        goals: sub-goals, without their targets.
        capacities: slots per shape of obstacles.
        parameters: of the planner.
    """

    def __init__(
        self, robot: Robot, goals: Sequence[GoalInfo], capacities: Mapping[str, int], parameters: MpcParameters
    ) -> None:
        self.state = State(robot)
        self._goals = goals
        self._capacities = capacities
        self._parameters = parameters

    @cached_property
    def balls(self) -> list[Ball]:
        """Balls of the robot that move."""
        every = (ball for balls in balls_of(self.state.robot, self._parameters).values() for ball in balls)
        return [
            ball
            for ball in every
            if isinstance(ball, Ball) and casadi.depends_on(ball.place(self.state.frames), self.state.q)
        ]

    def function(self) -> Any:
        """The composed stage.

        Of `q`, the targets `goals` one below the other, and a matrix `obstacles_SHAPE` per shape as in `layout.Slot`,
        to the Hessian `H` and gradient `g` of half the weighted squared errors, by q, as a function of q itself; and to
        the distances `d` with their Jacobian `J`.
        """
        q = self.state.q
        targets = casadi.SX.sym("goals", sum(goal.size for goal in self._goals))
        obstacles = {shape: self._symbols(shape, count) for shape, count in self._capacities.items()}
        errors = self._errors(targets)
        slope = casadi.jacobian(errors, q)
        hessian = slope.T @ slope
        rows = [*self._obstacle_rows(obstacles), *self._own_rows()]
        distances = casadi.vertcat(*(row[0] for row in rows)) if rows else casadi.SX(0, 1)
        gradients = casadi.vertcat(*(row[1] for row in rows)) if rows else casadi.SX(0, q.numel())
        results = [hessian, slope.T @ errors - hessian @ q, distances, gradients]
        names = ["q", "goals", *(f"obstacles_{shape}" for shape in obstacles)]
        return casadi.Function(
            "stage",
            [q, targets, *obstacles.values()],
            [casadi.densify(result) for result in results],
            names,
            ["H", "g", "d", "J"],
            {"cse": True},
        )

    def errors(self) -> Any:
        """Function of `q` and the targets `goals` to the errors, times the roots of their weights, (m, 1)."""
        targets = casadi.SX.sym("goals", sum(goal.size for goal in self._goals))
        errors = casadi.densify(self._errors(targets))
        return casadi.Function("errors", [self.state.q, targets], [errors], ["q", "goals"], ["e"], {"cse": True})

    def points(self) -> Any:
        """Function of q to the centres of all balls, (d, balls) [m], to find the nearest points of meshes."""
        places = casadi.horzcat(*(ball.place(self.state.frames) for ball in self.balls))
        return casadi.Function("points", [self.state.q], [casadi.densify(places)], ["q"], ["points"], {"cse": True})

    def _symbols(self, shape: str, count: int) -> Any:
        slots = count * len(self.balls) if shape == MESH else count
        return casadi.SX.sym(f"obstacles_{shape}", Slot(shape, self.state.robot.dimension).length, slots)

    def _errors(self, targets: Any) -> Any:
        """Errors of all sub-goals, times the roots of their weights."""
        errors, start = [], 0
        for goal in self._goals:
            target = targets[start : start + goal.size]
            error = ERRORS[self.state.robot.dimension, goal.type](self.state, goal, target, 0.0)
            errors.append(sqrt(goal.weight) * error)
            start += goal.size
        return casadi.vertcat(*errors)

    def _obstacle_rows(self, obstacles: Mapping[str, Any]) -> Iterator[Row]:
        """Of each ball its distances to the nearest obstacles."""
        if not obstacles:
            return
        q = self.state.q
        for place, ball in enumerate(self.balls):
            centre = ball.place(self.state.frames)
            slope = casadi.jacobian(centre, q)
            found = []
            for shape, symbols in obstacles.items():
                columns = casadi.horzsplit(symbols)
                near = self._distance_to(ball, shape)
                mine = columns[place :: len(self.balls)] if shape == MESH else columns
                found += [near(centre, column) for column in mine]
            kept = smallest(found, self._parameters.nearest)
            yield from ((distance - self._parameters.margin, gradient @ slope) for distance, gradient in kept)

    def _distance_to(self, ball: Ball, shape: str) -> Any:
        """Function of a ball's centre and an obstacle's numbers to their distance and its gradient by the centre."""
        slot = Slot(shape, self.state.robot.dimension)
        numbers = casadi.SX.sym("obstacle", slot.length)
        centre = casadi.SX.sym("centre", slot.dimension)
        distance = ball.distance(centre - numbers[slot.of_time(0)], slot.symbols(numbers))
        gradient = casadi.densify(casadi.jacobian(distance, centre))
        return casadi.Function(
            "near", [centre, numbers], [distance + (1.0 - numbers[slot.present]) * ABSENT_M, gradient], {"cse": True}
        )

    def _own_rows(self) -> Iterator[Row]:
        """Distances of the nearest pairs of the robot's own bodies."""
        parameters, state = self._parameters, self.state
        if not parameters.own_nearest:
            return
        found = []
        for first, second in pairs_of(state.robot, parameters):
            places = first.place(state.frames), second.place(state.frames)
            ends, others = ends_of(first, places[0]), ends_of(second, places[1])
            still = [[casadi.SX.zeros(end.numel(), 1) for end in side] for side in (ends, others)]
            mapped = segment_derivatives(ends, others, *still)
            slope = mapped.jacobian @ casadi.jacobian(casadi.vertcat(*places), state.q)
            found.append((mapped.value - first.radius - second.radius - parameters.own_margin, casadi.densify(slope)))
        yield from smallest(found, parameters.own_nearest)


def smallest(rows: Sequence[Row], count: int) -> list[Row]:
    """The rows with the smallest distances, so many of them in this order; all as they are if `count` is 0."""
    if not count or count >= len(rows):
        return list(rows)
    best: list[Row] = list(rows[:1])
    for row in rows[1:]:
        candidate = row
        for place, other in enumerate(best):
            nearer = candidate[0] < other[0]
            best[place] = _either(nearer, candidate, other)
            candidate = _either(nearer, other, candidate)
        if len(best) < count:
            best.append(candidate)
    return best


def _either(condition: Any, one: Row, other: Row) -> Row:
    return casadi.if_else(condition, one[0], other[0]), casadi.if_else(condition, one[1], other[1])
