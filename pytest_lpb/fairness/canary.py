"""Whether a planner looks at the scene: goal and obstacles are moved, and it is asked again.

A planner that kept the scene of an earlier trial, or never looked, gives the same action to the last bit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.planner.base import Planner, PlannerProblem
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.trial.guard import UserInterruptError, guarded
from pytest_lpb.trial.holder import PlannerHolder
from pytest_lpb.trial.loop import checked_action, undisturbed

GOAL, OBSTACLES = "goal", "obstacles"
Scene = dict[str, FloatArray]  # an observation, its arrays the caller's own

# Both sides, near and far: of an action at its limits, only a target on the other side of the robot changes the sign.
GOAL_STEPS = (0.5, -0.5, 10.0, -10.0)  # [m or rad] each number of a target is moved by
TOWARDS = (0.3, 0.6, 0.9)  # share of the way to the robot's last link that obstacles are moved by
# Targets that stay targets when something is added; alignments, and orientations in space, are left alone.
MOVABLE = {2: ("position", "orientation", "joint"), 3: ("position", "joint")}


def reactions(holder: PlannerHolder, configuration: PlannerConfiguration, problem: Problem) -> dict[str, bool | None]:
    """Whether the first action of a trial changes when the goal is moved, and when the obstacles are.

    The same instance is set up again before each call, so a planner that does not forget is found as well.

    Returns:
        `goal` and `obstacles`: whether any move changed the action, or None where there is nothing to move, or where
        the planner fails, or answers the same question differently each time.
    """
    question = _Question(holder, configuration, problem)
    scene = question.scene()
    still = question.ask(scene)
    if still is None or still != question.ask(scene):
        return {GOAL: None, OBSTACLES: None}
    moved = {GOAL: list(_goals_moved(scene, problem)), OBSTACLES: list(_obstacles_moved(scene, problem))}
    return {
        what: any(question.ask(scene) != still for scene in scenes) if scenes else None
        for what, scenes in moved.items()
    }


@dataclass(frozen=True)
class _Question:
    """What a planner is asked: its first action in a problem."""

    holder: PlannerHolder
    configuration: PlannerConfiguration
    problem: Problem

    @property
    def _parameters(self) -> Any:
        return self.configuration.parameters_for(self.problem.robot.name, self.problem.control)

    def scene(self) -> Scene:
        """The observation at the start."""
        environment = ScenarioEnvironment(
            problem=self.problem, preview=self.configuration.preview_for(self._parameters)
        )
        try:
            return environment.observe()
        finally:
            environment.close()

    def ask(self, scene: Scene) -> list[float] | None:
        """The action in a scene; None when the planner raises: in a scene that was moved, a reaction too."""
        period = self.configuration.steps_per_call(self.problem.dt) * self.problem.dt
        try:
            with guarded(self.problem.seed), undisturbed():
                return self._action(self.holder.get(), PlannerProblem.of(self.problem, period), scene)
        except UserInterruptError:
            raise KeyboardInterrupt from None
        except BaseException:
            return None

    def _action(self, planner: Planner, told: PlannerProblem, scene: Scene) -> list[float]:
        planner.parameters = self._parameters
        planner.diagnostics = {}
        planner.setup(told)
        return checked_action(planner.compute_action(_read_only(scene)), self.problem.robot.n_actions)


def _read_only(scene: Scene) -> Scene:
    """A copy, as protected as in a trial."""
    seen = {name: array.copy() for name, array in scene.items()}
    for array in seen.values():
        array.flags.writeable = False
    return seen


def _goals_moved(scene: Scene, problem: Problem) -> Iterator[Scene]:
    names = [f"goal_{goal.name}" for goal in problem.goal if goal.type in MOVABLE[problem.dimension]]
    if not names:
        return
    if f"goal_{problem.primary.name}" in names:
        names.append("goal_position")  # the primary goal by its other name
    for step in GOAL_STEPS:
        yield scene | {key: scene[key] + step for name in names for key in (name, f"{name}_preview") if key in scene}


def _obstacles_moved(scene: Scene, problem: Problem) -> Iterator[Scene]:
    if not problem.obstacles:
        return
    robot, size = problem.robot, problem.dimension
    here = robot.forward_kinematics(problem.start_q, robot.link_names[-1])[:size, size]
    way = here - scene["obstacle_position"]
    for share in TOWARDS:
        moved = {"obstacle_position": scene["obstacle_position"] + share * way}
        preview = scene.get("obstacle_position_preview")
        if preview is not None:
            moved["obstacle_position_preview"] = preview + share * way[:, None, :]
        yield scene | moved
