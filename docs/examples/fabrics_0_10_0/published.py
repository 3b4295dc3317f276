"""Release 0.10.0 of `fabrics` from PyPI as a planner, for points and arms among discs or spheres that stand still."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from fabrics.planner.parameterized_planner import ParameterizedFabricPlanner
from forwardkinematics.planarFks.point_fk import PointFk
from forwardkinematics.urdfFks.generic_urdf_fk import GenericURDFFk
from mpscenes.goals.goal_composition import GoalComposition

from pytest_lpb import Planner


class Published(Planner):
    """Composes a fabric with the parameters of the release, and asks it."""

    @dataclass(frozen=True)
    class Parameters:
        """Names that no problem tells."""

        root_link: str = "panda_link0"  # of arms

    def setup(self, problem):
        """Compose the fabric, unless it is that of the last trial."""
        goal = problem.goal[0]
        bodies = [body for body in problem.robot.collision_bodies if self._moves(body.link)]
        shape = (problem.robot.name, goal.link, len(problem.obstacles), tuple(body.link for body in bodies))
        if getattr(self, "shape", None) != shape:
            self.shape, self.planner = shape, self._composed(problem, goal.link, bodies)
        names = {body.link: self._link(problem, body.link) for body in bodies}
        self.constant = {f"radius_body_{names[body.link]}": np.array([body.capsules[0][-1]]) for body in bodies}
        self.constant["weight_goal_0"] = np.array([goal.weight])
        for i, obstacle in enumerate(problem.obstacles):
            self.constant[f"radius_obst_{i}"] = np.array([obstacle.radius])

    def compute_action(self, observation):
        """The fabric's acceleration."""
        moving = {f"x_obst_{i}": position for i, position in enumerate(observation["obstacle_position"])}
        return self.planner.compute_action(
            q=observation["q"],
            qdot=observation["qd"],
            x_goal_0=observation["goal_position"],
            **moving,
            **self.constant,
        )

    def _moves(self, link):
        return link != self.parameters.root_link

    def _link(self, problem, link):
        return link if problem.robot.urdf_path else 1  # a point's only link

    def _composed(self, problem, link, bodies):
        if problem.robot.urdf_path:
            urdf = Path(problem.robot.urdf_path).read_text()
            kinematics, root = GenericURDFFk(urdf, self.parameters.root_link, [link]), self.parameters.root_link
        else:
            kinematics, root = PointFk(), 0
        planner = ParameterizedFabricPlanner(problem.robot.dof, kinematics)
        target = {
            "weight": 1.0,
            "is_primary_goal": True,
            "indices": list(range(problem.dimension)),
            "parent_link": root,
            "child_link": self._link(problem, link),
            "desired_position": [0.0] * problem.dimension,  # given at each call
            "epsilon": 0.1,
            "type": "staticSubGoal",
        }
        planner.set_components(
            collision_links=[self._link(problem, body.link) for body in bodies],
            goal=GoalComposition(name="goal", content_dict={"reach": target}),
            limits=problem.robot.limits.position.tolist(),
            number_obstacles=len(problem.obstacles),
        )
        planner.concretize()
        return planner
