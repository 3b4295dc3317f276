"""Cameras: what is in the picture, and where."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.environment.camera import CLOSEST, Camera, direction, framing
from pytest_lpb.environment.paint import add_ball, add_samples, sampled
from pytest_lpb.environment.spatial_view import camera_for, start_frames
from pytest_lpb.environment.visuals import VisibleBodies
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.spatial.client import Client
from tests.problem.spatial.entries import Entry, point_entry, problem_of

SIZE = (64, 48)
coordinate = st.floats(-5.0, 5.0)
GREEN = (0, 158, 115)


@given(
    st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=2, max_size=20, unique=True),
    st.floats(-pi, pi),
    st.floats(-1.3, 1.3),
)
def test_framing_holds_everything_and_no_more(
    places: list[tuple[float, float, float]], azimuth: float, elevation: float
) -> None:
    points = np.array(places)
    # Points all in one line of sight have no size to fill the picture with.
    points = np.concatenate([points, points + 0.1, points - (0.1, -0.1, 0.1)])
    camera = framing(points, direction(azimuth, elevation), SIZE)
    seen, depth = camera.project(points)
    assert (depth > 0).all()
    assert (seen > -1e-6).all()
    assert (seen < np.array(SIZE) + 1e-6).all()
    edges = np.concatenate([np.abs(seen), np.abs(seen - SIZE)])
    as_near_as_may_be = depth.min() < (CLOSEST + 1e-9) * camera.distance
    assert as_near_as_may_be or edges.min() < 1e-6


def test_a_camera_sees_along_its_rays() -> None:
    camera = Camera(np.array([2.0, -1.0, 1.5]), np.array([0.0, 0.5, 0.2]), *SIZE)
    points = camera.eye + 1.7 * camera.rays[[3, 40], [60, 7]]
    places, depth = camera.project(points)
    assert places == pytest.approx(np.array([[60.5, 3.5], [7.5, 40.5]]))
    assert depth == pytest.approx([1.7, 1.7])
    assert np.isnan(camera.project(camera.eye[None] - camera.axes[2])[1]).all()


def test_pybullet_renders_what_the_camera_projects() -> None:
    client = Client()
    camera = Camera(np.array([2.0, -1.5, 1.5]), np.array([0.0, 0.2, 0.3]), 320, 240)
    points = np.array([[0.3, 0.2, 0.5], [-0.4, 0.1, 0.3], [0.0, -0.3, 0.9]])
    shape = client.call("createVisualShape", 3, halfExtents=[0.01] * 3)
    for point in points:
        client.call("createMultiBody", baseVisualShapeIndex=shape, basePosition=point.tolist())
    _, depth, bodies = camera.take(client)
    client.close()
    places, away = camera.project(points)
    for body, place in enumerate(places):
        rows, columns = np.nonzero(bodies == body)
        assert np.array([columns.mean() + 0.5, rows.mean() + 0.5]) == pytest.approx(place, abs=1.0)
        assert depth[rows, columns].mean() == pytest.approx(away[body], abs=0.02)
    assert np.isinf(depth[bodies < 0]).all()


def test_a_ball_is_round_and_hidden_by_what_is_nearer() -> None:
    camera = Camera(np.array([0.0, -4.0, 0.0]), np.zeros(3), 200, 200)
    depth = np.full((200, 200), np.inf)
    depth[:, :100] = 2.0
    picture = np.full((200, 200, 3), 255, dtype=np.uint8)
    add_ball(picture, depth, camera, np.zeros(3), 0.5, GREEN)
    drawn = (picture != 255).any(axis=2)
    assert not drawn[:, :100].any()
    # Half of a disc; a ball seen from near looks larger than its radius over its distance.
    radius = camera.focal_length * 0.5 / np.sqrt(16.0 - 0.25)
    assert drawn.sum() == pytest.approx(0.5 * np.pi * radius**2, rel=0.03)
    for place in ([0.0, -4.2, 0.0], [0.0, -4.0, 0.1], [0.0, -9.0, 0.0], [50.0, 0.0, 0.0]):
        before = picture.copy()
        add_ball(picture, depth, camera, np.array(place), 0.5, GREEN)
        assert (picture == before).all()


def test_a_line_is_drawn_as_far_as_it_is_in_the_picture() -> None:
    camera = Camera(np.array([0.0, -4.0, 0.0]), np.zeros(3), 200, 200)
    depth = np.full((200, 200), np.inf)
    depth[:, 100:] = 1.0
    picture = np.full((200, 200, 3), 255, dtype=np.uint8)
    add_samples(picture, depth, sampled(camera, np.array([[-100.0, 0.0, 0.0], [100.0, 0.0, 0.0]])), GREEN)
    assert (picture[100, 10:90] == GREEN).all()
    faint = picture[100, 110:190]
    assert (faint != GREEN).any(axis=1).all()
    assert (faint != 255).any(axis=1).all()
    assert (picture[:90] == 255).all()
    for points in (
        [[0.0, -9.0, 0.0], [0.0, 9.0, 0.0]],
        [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        [[9e9, 0.0, 0.0], [9e9, 1.0, 0.0]],
    ):
        assert len(sampled(camera, np.array(points))) == 0


BOX = {"shape": "box", "size": [0.1, 2.0, 2.0]}


def _camera(problem: Problem) -> Camera:
    client = Client()
    bodies = VisibleBodies(client, problem)
    bodies.place(0.0, start_frames(problem))
    camera = camera_for(problem, client, bodies, SIZE)
    client.close()
    return camera


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_one_looks_from_where_the_robot_is_seen(tmp_path: Path, side: float) -> None:
    """Walls stand around robot and goal, but for one side."""
    goal = {"name": "reach", "type": "position", "link": "body", "target": [0.3, 0.0, 1.0], "tolerance": 0.1}
    ends = [{**BOX, "name": f"end{x}", "position": [x, 0.0, 1.0]} for x in (-1, 1)]
    back: Entry = {"name": "back", "shape": "box", "size": [2.0, 0.1, 2.0], "position": [0.0, side, 1.0]}
    entry = point_entry(0.1, [*ends, back], start={"q": [-0.3, 0.0, 1.0]}, goal=[goal])
    camera = _camera(problem_of(tmp_path, entry))
    assert side * camera.eye[1] < 0


def test_a_floor_that_goes_on_does_not_shrink_the_picture(tmp_path: Path) -> None:
    floor: Entry = {"name": "floor", "shape": "box", "size": [100.0, 100.0, 0.1], "position": [0.0, 0.0, -1.0]}
    goal = {"name": "reach", "type": "position", "link": "body", "target": [1.0, 0.0, 0.0], "tolerance": 0.1}
    without, with_floor = (
        _camera(problem_of(tmp_path, point_entry(0.1, obstacles, goal=[goal]))) for obstacles in ([], [floor])
    )
    assert with_floor.distance < 3.0 * without.distance
