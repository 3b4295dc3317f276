"""`lpb/Scenario-v0`: a scenario as a gymnasium environment. The trial loop and reinforcement learning use the same."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import inf, isfinite, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from pytest_lpb.environment.engine import Engine, engine_for
from pytest_lpb.environment.limits import ActionLimits
from pytest_lpb.environment.monitor import Monitor
from pytest_lpb.environment.observation import Observation
from pytest_lpb.environment.spaces import ACTION_BOUND, action_limits, action_space, bounds_of, observation_space
from pytest_lpb.errors import LpbError
from pytest_lpb.names import listed, suggestion
from pytest_lpb.problem.preview import Preview
from pytest_lpb.problem.problem import Problem

if TYPE_CHECKING:
    from pytest_lpb.scenario.load import Scenario

Observations = dict[str, Any]
OPTIONS = ("problem",)  # of a reset


class ScenarioEnvironment(gymnasium.Env[Observations, NDArray[np.float64]]):
    """One robot, its goal and its obstacles.

    Args:
        scenario: a scenario or the path of its file; `reset(seed=K)` then sets up problem K.
        problem: a concrete problem instead; every reset sets it up again.
        render_mode: None, `human` or `rgb_array`.
        preview: what the planner wants to see of the future.
        reuse_observations: hand out the same read-only arrays at each step instead of copies.
        action_bound: the action space has ±this where the robot has no limit, since learning needs a finite one; one
            number, or one per action. `step` does not clip to it: the robot's own limits do.

    Raises ScenarioError for a scenario that cannot be used, LpbError for other arguments.
    """

    metadata = {"render_modes": ["human", "rgb_array"], "render_fps": 20}  # noqa: RUF012 - gymnasium's own attribute

    def __init__(
        self,
        scenario: Scenario | Path | str | None = None,
        *,
        problem: Problem | None = None,
        render_mode: str | None = None,
        preview: Preview | None = None,
        reuse_observations: bool = False,
        action_bound: float | Sequence[float] = ACTION_BOUND,
    ) -> None:
        if (scenario is None) == (problem is None):
            raise LpbError("ScenarioEnvironment needs a scenario or a problem, and not both")
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise LpbError(f"render_mode {render_mode!r} is unknown; allowed: human, rgb_array, None")
        self.scenario = None if scenario is None else _feasible(scenario)
        self.render_mode = render_mode
        self._preview = preview
        self._reuse = reuse_observations
        self._window: Any = None
        self._capacity: int | None = None
        self._padded = False
        self.engine: Engine | None = None
        first = problem if problem is not None else self._draw(None)
        self._action_bounds = bounds_of(action_bound, first.robot.n_actions)
        if self.scenario is not None:
            # Trials run concrete problems: they never need what reads and draws scenarios.
            from pytest_lpb.scenario.draw import obstacle_counts

            fewest, self._capacity = obstacle_counts(self.scenario)
            self._padded = fewest < self._capacity
        self._load(first)
        self._restart()

    @cached_property
    def action_space(self) -> Any:  # type: ignore[override] # gymnasium declares attributes
        """Box of the robot's limits, finite. Spaces are made when asked for: trials never do."""
        return action_space(self.problem, self._action_bounds)

    @cached_property
    def observation_space(self) -> Any:  # type: ignore[override] # as above
        """Dict of one Box per key of the observation."""
        return observation_space(self._observation.views)

    def _draw(self, seed: int | None) -> Problem:
        from pytest_lpb.scenario.draw import draw_problem

        assert self.scenario is not None
        return draw_problem(self.scenario, self.scenario.seed if seed is None else seed)

    def _load(self, problem: Problem) -> None:
        if self.engine is not None:
            self.engine.close()
        self.problem = problem
        capacity = len(problem.obstacles) if self._capacity is None else self._capacity
        self.engine = engine_for(problem)
        self._limits = ActionLimits(problem.robot, problem.dt)
        self._observation = Observation(problem, self._preview, capacity, padded=self._padded)

    def _restart(self) -> None:
        """Back to row 0 of the loaded problem."""
        problem, engine = self.problem, self.running_engine
        self.row = 0
        self.applied: list[float] = []
        self.saturated_steps = 0
        self.outcome: str | None = None
        self.monitor = Monitor(problem)
        for index, timeline in enumerate(self._observation.goals):
            self.monitor.set_target(index, timeline.at(0)[0][0].tolist())
        engine.set_state(problem.start_q.tolist(), problem.start_u.tolist())
        self._observation.update(0, engine.q, engine.qd, engine.u)
        engine.place_obstacles(*self._observation.obstacle_poses())
        self.monitor.begin(engine)
        self._distance = self.monitor.goal_distance
        self._has_units = len(self.monitor.primary_errors) > 1
        self._radius, self._tolerance = problem.robot.body_radius, self.monitor.goal_tolerance
        self._finish()

    @property
    def running_engine(self) -> Engine:
        """The engine. Raises LpbError after `close`."""
        if self.engine is None:
            raise LpbError("this environment is closed; make a new one")
        return self.engine

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Start a trial.

        Args:
            seed: sets up problem `seed` of the scenario; without it a problem is drawn by the environment's own random
                numbers, which start anew with each seed that is given, and from the system's entropy before the first.
            options: `{"problem": Problem}` sets up that one; it must fit the spaces.

        Raises LpbError for a problem that does not fit, for unknown options, and after `close`.
        """
        self.running_engine  # noqa: B018 - raises when closed
        given = _checked_options(options).get("problem")
        super().reset(seed=seed)
        if given is not None:
            self._load(self._fitting(given))
        elif self.scenario is not None:
            self._load(self._draw(int(self.np_random.integers(2**31)) if seed is None else seed))
        self._restart()
        self._render_if_human()
        return self.observe(), self._info()

    def step(self, action: NDArray[np.float64] | list[float]) -> tuple[Observations, float, bool, bool, dict[str, Any]]:
        """Apply an action (n_actions,) for one step of dt. Actions beyond the limits are clipped and counted."""
        distance = self._distance
        self.advance(action)
        reward = distance - self._distance
        violation = self.monitor.violation
        if violation is not None and violation.row == self.row:
            reward -= 1.0
        return self.observe(), reward, self.terminated, self.truncated, self._info()

    def advance(self, action: NDArray[np.float64] | list[float]) -> None:
        """What `step` does, without observation, reward and info: the trial loop does not read them."""
        values = self._checked(action)
        engine, monitor = self.running_engine, self.monitor
        self.applied = self._limits.apply(values, engine.u)
        if self.applied != values:
            self.saturated_steps += 1
        engine.advance(self.applied)
        self.row += 1
        self._observe_row(engine)
        monitor.check(self.row, engine)
        self._distance = monitor.goal_distance
        self._finish()
        self._render_if_human()

    def _fitting(self, problem: Any) -> Problem:
        """A problem given by the user. Raises LpbError unless actions and observations keep their shapes."""
        if not isinstance(problem, Problem):
            raise LpbError(f"options: problem: found {problem!r}; a pytest_lpb.Problem is needed")
        capacity = len(problem.obstacles) if self._capacity is None else self._capacity
        if len(problem.obstacles) > capacity:
            raise LpbError(
                f"options: problem: it has {len(problem.obstacles)} obstacles; this environment has room for {capacity}"
            )
        views = Observation(problem, self._preview, capacity, padded=self._padded).views
        shapes = {name: view.shape for name, view in views.items()}
        present = {name: view.shape for name, view in self._observation.views.items()}
        if shapes != present or not np.array_equal(action_limits(problem), action_limits(self.problem)):
            raise LpbError(
                "options: problem: its observations or actions differ from this environment's; make one for it"
            )
        return problem

    def _checked(self, action: NDArray[np.float64] | list[float]) -> list[float]:
        size = self.problem.robot.n_actions
        try:
            values: list[float] = action if isinstance(action, list) else np.asarray(action, dtype=float).tolist()
            finite = len(values) == size and all(map(isfinite, values))
        except (TypeError, ValueError):
            finite = False
        if not finite:
            raise LpbError(f"action {' '.join(repr(action).split())} must be {size} finite numbers")
        return values

    def _observe_row(self, engine: Engine) -> None:
        observation = self._observation
        observation.update(self.row, engine.q, engine.qd, engine.u)
        for index, timeline in observation.moving_goals:
            self.monitor.set_target(index, timeline.at(self.row)[0][0].tolist())
        if observation.obstacles_move:
            engine.place_obstacles(*observation.obstacle_poses())

    def _finish(self) -> None:
        monitor, ends = self.monitor, self.problem.end_at
        self.terminated = (monitor.goal_row is not None and "goal" in ends) or (
            monitor.violation is not None and "violation" in ends
        )
        self.truncated = self.row >= self.problem.steps
        if self.terminated or self.truncated:
            self.outcome = monitor.outcome(self.row)

    @property
    def ended(self) -> bool:
        """Whether the trial is over."""
        return self.terminated or self.truncated

    def observe(self) -> Observations:
        """The observation of the current row."""
        return self._observation.views if self._reuse else self._observation.copy()

    def _info(self) -> dict[str, Any]:
        """Never NaN, which is not equal to itself: gymnasium compares the infos of equal steps."""
        monitor, violation = self.monitor, self.monitor.violation
        clearance = monitor.clearance[0]
        info = {
            "goal_distance": self._distance,
            "clearance": inf if isnan(clearance) else clearance,
            "contact_time": inf if violation is None or violation.time is None else violation.time,
            "outcome": self.outcome or "running",
            "robot_radius": self._radius,
            "goal_tolerance": self._tolerance,
        }
        if self._has_units:
            info |= {f"goal_error_{unit}": error for unit, error in monitor.primary_errors.items()}
        return info

    def render(self) -> Any:
        """A picture of the current row: (height, width, 3) uint8 with `rgb_array`; a window with `human`."""
        if self.render_mode is None:
            return None
        if self._window is None:
            from pytest_lpb.environment.picture import picture_for

            self._window = picture_for(self.problem.dimension, show=self.render_mode == "human")
        return self._window.draw(self.problem, self.row, self.running_engine.q)

    def _render_if_human(self) -> None:
        if self.render_mode == "human":
            self.render()

    def close(self) -> None:
        """Close the engine and the window."""
        if self.engine is not None:
            self.engine.close()
            self.engine = None
        if self._window is not None:
            self._window.close()
            self._window = None


def _checked_options(options: dict[str, Any] | None) -> dict[str, Any]:
    """Options of a reset. Raises LpbError for unknown ones."""
    if options is not None and not isinstance(options, dict):
        raise LpbError(f"options: found {options!r}; a dict is needed; allowed: {listed(OPTIONS)}")
    for key in options or {}:
        if key not in OPTIONS:
            raise LpbError(f"options: unknown {key!r}{suggestion(str(key), OPTIONS)}; allowed: {listed(OPTIONS)}")
    return options or {}


def _feasible(scenario: Scenario | Path | str) -> Scenario:
    """A scenario whose fixed start and goal are free. Raises ScenarioError."""
    from pytest_lpb.scenario.draw import check_feasible
    from pytest_lpb.scenario.load import load_scenario

    loaded = load_scenario(Path(scenario)) if isinstance(scenario, str | Path) else scenario
    check_feasible(loaded)
    return loaded
