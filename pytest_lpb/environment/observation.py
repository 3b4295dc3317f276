"""What a planner sees: one dictionary of arrays that are filled again at each step."""

from __future__ import annotations

from typing import Any

import numpy as np

from pytest_lpb.environment.timeline import Timeline
from pytest_lpb.problem.extents import extents_of
from pytest_lpb.problem.preview import Preview
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray

ORIENTATION_SIZES = {2: 1, 3: 4}  # numbers per obstacle, by dimension: an angle [rad], a quaternion wxyz


class Predictor:
    """Fills one preview array by the environment's `prediction`."""

    def __init__(self, timeline: Timeline, preview: Preview, prediction: str) -> None:
        self._timeline = timeline
        self._ahead = np.arange(1, preview.steps + 1, dtype=np.float64) * preview.step_s  # [s]
        self._exact = prediction == "exact"
        self._still = prediction == "none"

    def predict(self, t: float, position: FloatArray, velocity: FloatArray) -> FloatArray:
        """Predicted positions (n, steps, size) of n things at `position` with `velocity`, each (n, size)."""
        if self._exact:
            return self._timeline.positions(np.add(t, self._ahead))
        ahead = np.zeros_like(self._ahead) if self._still else self._ahead
        predicted: FloatArray = position[:, None, :] + ahead[:, None] * velocity[:, None, :]
        return predicted


class Observation:
    """Buffers of one problem's observation; `views` are their read-only faces, handed to the planner.

    Args:
        problem: the concrete problem.
        preview: what the planner wants to see of the future, or None.
        capacity: rows of the obstacle arrays; those beyond the problem's obstacles stay zero.
        padded: whether to say which rows are obstacles, in `obstacle_present`: 1.0, others 0.0.
    """

    def __init__(self, problem: Problem, preview: Preview | None, capacity: int, *, padded: bool = False) -> None:
        self._problem = problem
        self._buffers: dict[str, FloatArray] = {}
        robot = problem.robot
        self._t = self._buffer("t", ())
        self._q = self._buffer("q", (robot.dof,))
        self._qd = self._buffer("qd", (robot.dof,))
        self._u = self._buffer("u", (robot.n_actions,)) if robot.non_holonomic else self._alias("u", "qd")
        self._same = self._u is self._qd
        self.goals = [Timeline([goal.motion], goal.motion.size, problem.dt) for goal in problem.goal]
        self._goal_buffers = [self._add_goal(goal.name, goal.motion.size) for goal in problem.goal]
        self.moving_goals = [(index, timeline) for index, timeline in enumerate(self.goals) if timeline.moving]
        for suffix in ("position", "velocity", "acceleration"):
            source = f"goal_{problem.primary.name}" + ("" if suffix == "position" else f"_{suffix}")
            self._alias(f"goal_{suffix}", source)
        self._add_obstacles(capacity)
        if padded:
            self._buffer("obstacle_present", (capacity,))[: len(problem.obstacles)] = 1.0
        self._previews: list[tuple[FloatArray, Predictor, FloatArray, FloatArray]] = []
        if preview is not None:
            self._add_previews(preview)
        self.views = {name: _read_only(buffer) for name, buffer in self._buffers.items()}
        for index, timeline in enumerate(self.goals):
            self._fill_goal(index, timeline, 0)
        self._fill_obstacles(0, every=True)

    def _buffer(self, name: str, shape: tuple[int, ...]) -> FloatArray:
        self._buffers[name] = np.zeros(shape)
        return self._buffers[name]

    def _alias(self, name: str, source: str) -> FloatArray:
        self._buffers[name] = self._buffers[source]
        return self._buffers[name]

    def _add_goal(self, name: str, size: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        return (
            self._buffer(f"goal_{name}", (size,)),
            self._buffer(f"goal_{name}_velocity", (size,)),
            self._buffer(f"goal_{name}_acceleration", (size,)),
        )

    def _add_obstacles(self, capacity: int) -> None:
        problem = self._problem
        self.obstacles = Timeline([o.motion for o in problem.obstacles], problem.dimension, problem.dt)
        size = ORIENTATION_SIZES[problem.dimension]
        self.turning = Timeline([o.turning for o in problem.obstacles], size, problem.dt)
        self.obstacles_move = self.obstacles.moving or self.turning.moving
        shape = (capacity, problem.dimension)
        arrays = [self._buffer(f"obstacle_{name}", shape) for name in ("position", "velocity", "acceleration")]
        orientation = self._buffer("obstacle_orientation", (capacity,) if size == 1 else (capacity, size))
        count = len(problem.obstacles)
        sizes = self._buffer("obstacle_size", shape)
        for row, obstacle in enumerate(problem.obstacles):
            sizes[row] = extents_of(obstacle)
        self._obstacle_buffers = [array[:count] for array in arrays]
        self._orientation = orientation[:count]
        self._turns = self._orientation.reshape(count, size)  # the same numbers, a row per obstacle

    def _add_previews(self, preview: Preview) -> None:
        problem = self._problem
        for goal, timeline, (position, velocity, _) in zip(problem.goal, self.goals, self._goal_buffers, strict=True):
            array = self._buffer(f"goal_{goal.name}_preview", (preview.steps, goal.motion.size))
            predictor = Predictor(timeline, preview, problem.prediction)
            self._previews.append((array[None], predictor, position[None], velocity[None]))
        capacity = len(self._buffers["obstacle_position"])
        array = self._buffer("obstacle_position_preview", (capacity, preview.steps, problem.dimension))
        predictor = Predictor(self.obstacles, preview, problem.prediction)
        position, velocity, _ = self._obstacle_buffers
        self._previews.append((array[: len(position)], predictor, position, velocity))

    def update(self, row: int, q: list[float], qd: list[float], u: list[float]) -> None:
        """Fill in the state at t = row dt."""
        t = row * self._problem.dt
        self._t[()] = t
        self._q[:] = q
        self._qd[:] = qd
        if not self._same:
            self._u[:] = u
        for index, timeline in self.moving_goals:
            self._fill_goal(index, timeline, row)
        if self.obstacles_move:
            self._fill_obstacles(row, every=False)
        for array, predictor, position, velocity in self._previews:
            array[:] = predictor.predict(t, position, velocity)

    def _fill_goal(self, index: int, timeline: Timeline, row: int) -> None:
        for buffer, values in zip(self._goal_buffers[index], timeline.at(row), strict=True):
            buffer[:] = values[0]

    def _fill_obstacles(self, row: int, *, every: bool) -> None:
        if self.obstacles.moving or every:
            for buffer, values in zip(self._obstacle_buffers, self.obstacles.at(row), strict=True):
                buffer[:] = values
        if self.turning.moving or every:
            self._turns[:] = self.turning.at(row)[0]

    def obstacle_poses(self) -> tuple[list[list[float]], list[Any]]:
        """Positions and orientations (angles, or quaternions wxyz) of the problem's obstacles now, for the engine."""
        return self._obstacle_buffers[0].tolist(), self._orientation.tolist()

    def copy(self) -> dict[str, Any]:
        """The observation as arrays of the caller's own."""
        return {name: view.copy() for name, view in self.views.items()}


def _read_only(array: FloatArray) -> FloatArray:
    # Not array.view(): whose view it is may make that writeable again.
    return np.asarray(array.data.toreadonly())
