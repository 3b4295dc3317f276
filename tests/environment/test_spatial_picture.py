"""Pictures of spatial trials, looked at pixel by pixel."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.environment import planar_picture
from pytest_lpb.environment.camera import Camera
from pytest_lpb.environment.picture import picture_for
from pytest_lpb.environment.spatial_picture import GOAL, HEIGHT, PATH, WIDTH, RenderedScene
from pytest_lpb.problem.problem import Problem
from tests.problem.spatial.entries import Entry, panda_entry, point_entry, problem_of, write_torus

Image = NDArray[np.uint8]
Point = Sequence[float] | NDArray[np.float64]

SHAPES: dict[str, Entry] = {
    "sphere": {"radius": 0.3},
    "box": {"size": [0.5, 0.5, 0.5], "orientation": {"axis": [0, 0, 1], "angle": 0.5}},
    "cylinder": {"radius": 0.25, "length": 0.6},
    "capsule": {"radius": 0.25, "length": 0.3},
}
GOAL_AT = [2.0, 0.0, 1.0]


def reach(target: Sequence[float] = GOAL_AT, **changes: Any) -> Entry:
    return {"name": "reach", "type": "position", "link": "body", "target": list(target), "tolerance": 0.25, **changes}


def point_problem(folder: Path, obstacles: Sequence[Entry] = (), **parts: Any) -> Problem:
    """A ball of 0.2 m in the middle of the world, and a goal."""
    return problem_of(folder, point_entry(0.2, obstacles, **{"goal": [reach()], **parts}))


def color_at(picture: Image, camera: Camera, point: Point) -> NDArray[np.int64]:
    (place,), _ = camera.project(np.array([point], dtype=float))
    column, row = place.astype(int)
    assert 0 <= column < WIDTH
    assert 0 <= row < HEIGHT
    return np.asarray(picture[row, column].astype(np.int64))


def is_grey(color: NDArray[np.int64]) -> bool:
    return int(np.ptp(color)) <= 6 and 60 < color.mean() < 140


def is_blue(color: NDArray[np.int64]) -> bool:
    return bool(color[2] > color[1] + 30 > color[0] + 30)


def is_green(color: NDArray[np.int64]) -> bool:
    return bool(color[1] > color[0] + 20 and color[1] > color[2])


@pytest.fixture
def scenes() -> Iterator[Any]:
    """Makes scenes that are closed at the end."""
    made: list[RenderedScene] = []

    def make(problem: Problem) -> RenderedScene:
        made.append(RenderedScene(problem, None))
        return made[-1]

    yield make
    for scene in made:
        scene.close()


@pytest.mark.parametrize("shape", SHAPES)
def test_robot_goal_and_obstacle_are_where_they_belong(scenes: Any, tmp_path: Path, shape: str) -> None:
    entry = {"name": "thing", "shape": shape, "position": [0.0, 1.5, 0.5], **SHAPES[shape]}
    scene = scenes(point_problem(tmp_path, [entry]))
    picture = scene.picture(0.0, [0.0, 0.0, 0.0])
    assert picture.shape == (HEIGHT, WIDTH, 3)
    assert picture.dtype == np.uint8
    assert is_blue(color_at(picture, scene.camera, [0.0, 0.0, 0.0]))
    assert is_grey(color_at(picture, scene.camera, [0.0, 1.5, 0.5]))
    beside_the_cross = np.array(GOAL_AT) + 0.16 * scene.camera.axes[:2].sum(axis=0) / 2**0.5
    assert is_green(color_at(picture, scene.camera, beside_the_cross))


def test_a_concave_mesh_has_its_hole(scenes: Any, tmp_path: Path) -> None:
    file = write_torus(tmp_path / "torus.obj", 0.6, 0.12)
    upright = {"axis": [1, 0, 0], "angle": 1.5708}
    ring = {"name": "ring", "shape": "mesh", "file": str(file), "concave": True, "position": [0.0, 1.5, 1.0]}
    scene = scenes(point_problem(tmp_path, [{**ring, "orientation": upright}]))
    picture = scene.picture(0.0, [0.0, 0.0, 0.0])
    assert is_grey(color_at(picture, scene.camera, [0.6, 1.5, 1.0]))
    assert is_grey(color_at(picture, scene.camera, [0.0, 1.5, 1.6]))
    assert color_at(picture, scene.camera, [0.0, 1.5, 1.0]).mean() > 180


def test_the_robot_moves_and_leaves_a_path(scenes: Any, tmp_path: Path) -> None:
    scene = scenes(point_problem(tmp_path))
    scene.picture(0.0, [0.0, 0.0, 0.0])
    picture = scene.picture(0.1, [1.2, 0.0, 0.6])
    off_the_path = 0.1 * scene.camera.axes[1]
    assert is_blue(color_at(picture, scene.camera, np.array([1.2, 0.0, 0.6]) + off_the_path))
    assert not is_blue(color_at(picture, scene.camera, off_the_path))
    assert color_at(picture, scene.camera, [0.6, 0.0, 0.3]).tolist() == list(PATH)
    scene.restart()
    picture = scene.picture(0.0, [0.0, 0.0, 0.0])
    assert color_at(picture, scene.camera, [0.6, 0.0, 0.3]).tolist() != list(PATH)


def test_obstacles_and_goals_move_with_time(scenes: Any, tmp_path: Path) -> None:
    ball = {"name": "ball", "shape": "sphere", "radius": 0.3, "trajectory": ["0", "1.5 - 3*t", "0.5"]}
    goal = {"name": "reach", "type": "position", "link": "body", "trajectory": ["2 - 2*t", "1", "1"], "tolerance": 0.2}
    scene = scenes(point_problem(tmp_path, [ball], goal=[goal]))
    aside = 0.13 * scene.camera.axes[:2].sum(axis=0) / 2**0.5
    for t in (0.0, 1.0):
        picture = scene.picture(t, [0.0, 0.0, 0.0])
        assert is_grey(color_at(picture, scene.camera, [0.0, 1.5 - 3 * t, 0.5]))
        assert not is_grey(color_at(picture, scene.camera, [0.0, 1.5 - 3 * (1 - t), 0.5]))
        assert is_green(color_at(picture, scene.camera, np.array([2.0 - 2.0 * t, 1.0, 1.0]) + aside))


def test_what_hides_a_goal_is_in_front_of_it(scenes: Any, tmp_path: Path) -> None:
    box = {"name": "crate", "shape": "box", "size": [0.8, 0.8, 0.8], "position": GOAL_AT}
    problem = point_problem(tmp_path, [box], environment={"end_at": []})
    scene = scenes(problem)
    picture = scene.picture(0.0, [0.0, 0.0, 0.0])
    assert is_grey(color_at(picture, scene.camera, np.array(GOAL_AT) + 0.1 * scene.camera.axes[0]))


def test_an_orientation_goal_is_a_frame(scenes: Any, tmp_path: Path) -> None:
    goals = [
        {"name": "reach", "type": "position", "link": "panda_hand", "target": [0.6, 0.4, 0.7], "primary": True},
        {"name": "turn", "type": "orientation", "link": "panda_hand", "target": [0, 1, 0, 0], "tolerance": 0.1},
    ]
    scene = scenes(problem_of(tmp_path, panda_entry(goal=goals)))
    picture = scene.picture(0.0, [1.0, 0.0, 0.0, -1.5, 0.0, 1.8675, 0.0])
    step = 0.025 * scene.camera.distance
    # Turned by half a turn about x: y and z point backwards.
    for axis, sign, channel in ((0, 1.0, 0), (1, -1.0, 1), (2, -1.0, 2)):
        point = np.array([0.6, 0.4, 0.7])
        point[axis] += sign * step
        color = color_at(picture, scene.camera, point)
        assert color.argmax() == channel
        assert color.max() > color.min() + 60


def test_a_goal_of_some_axes_is_beside_the_robot(scenes: Any, tmp_path: Path) -> None:
    goal = reach([1.5, 0.8], axes=[0, 2], tolerance=0.3)
    scene = scenes(point_problem(tmp_path, goal=[goal]))
    for y in (0.0, 0.7):
        picture = scene.picture(0.0, [0.0, y, 0.0])
        assert color_at(picture, scene.camera, [1.5, y, 0.8])[1] > 120
        assert is_green(color_at(picture, scene.camera, np.array([1.5, y, 0.8]) + 0.15 * scene.camera.axes[0]))


def test_links_without_visuals_show_their_collision_geometry(scenes: Any, tmp_path: Path) -> None:
    urdf = tmp_path / "slider.urdf"
    ball = '<geometry><sphere radius="0.3"/></geometry>'
    visual = f'<visual>{ball}<material name="r"><color rgba="0.9 0.1 0.1 1"/></material></visual>'
    urdf.write_text(
        f'<robot name="slider"><link name="foot"/><link name="plain"><collision>{ball}</collision></link>'
        f'<link name="red">{visual}</link>'
        '<joint name="slide" type="prismatic"><parent link="foot"/><child link="plain"/><axis xyz="1 0 0"/>'
        '<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
        '<joint name="weld" type="fixed"><parent link="plain"/><child link="red"/><origin xyz="0 1 0"/></joint></robot>'
    )
    entry = panda_entry(robot={"urdf": str(urdf)}, start={"q": [0.8]})
    entry["robot"].pop("model")
    entry["goal"][0]["joints"] = ["slide"]
    scene = scenes(problem_of(tmp_path, entry))
    picture = scene.picture(0.0, [0.8])
    assert is_blue(color_at(picture, scene.camera, [0.8, 0.0, 0.0]))
    red = color_at(picture, scene.camera, [0.8, 1.0, 0.0])
    assert red[0] > red[1] + 60


def test_pictures_do_not_disturb_the_simulation(tmp_path: Path) -> None:
    path = tmp_path / "panda.yaml"
    ball = {"name": "ball", "shape": "sphere", "radius": 0.1, "position": [0.5, 0.0, 0.5]}
    path.write_text(dump_yaml(panda_entry([ball])))
    rows = []
    for mode in (None, "rgb_array"):
        environment = gymnasium.make("lpb/Scenario-v0", scenario=path, render_mode=mode).unwrapped
        environment.reset(seed=0)
        for _ in range(5):
            observation, _, _, _, info = environment.step(np.full(7, 0.5))
            if mode is not None:
                picture: Any = environment.render()
                assert picture.shape == (HEIGHT, WIDTH, 3)
                assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 100
        rows.append([*observation["q"], info["clearance"]])
        environment.close()
    assert rows[0] == rows[1]


def test_a_picture_goes_from_problem_to_problem(tmp_path: Path) -> None:
    picture = picture_for(3, show=False)
    drawn = []
    for height in (0.4, 1.4, 0.4):
        ball = {"name": "ball", "shape": "sphere", "radius": 0.3, "position": [0.0, 1.5, height]}
        drawn.append(np.asarray(picture.draw(point_problem(tmp_path, [ball]), 0, [0.0, 0.0, 0.0])))
    picture.close()
    picture.close()
    assert not np.array_equal(drawn[0], drawn[1])
    assert np.array_equal(drawn[0], drawn[2])


def test_goal_and_path_have_the_colours_of_planar_pictures() -> None:
    for planar, spatial in ((planar_picture.GOAL, GOAL), (planar_picture.PATH, PATH)):
        assert tuple(bytes.fromhex(planar[1:])) == spatial
