"""Pictures of spatial problems in the report: from above and from the side."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.spatial.rotations import matrix_of, normalised
from pytest_lpb.problem.spatial.solids import RIM_POINTS, geometry_of, pose_from, solid_of
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.palette import planner_styles
from pytest_lpb.report.projection import PROJECTIONS, Disc, convex_hull, corners_of
from pytest_lpb.report.report import page, render, write_report
from pytest_lpb.report.scenes import scenes
from pytest_lpb.report.spatial_depiction import SpatialDepiction, silhouette
from pytest_lpb.report.view import Mark, Panel, Scene

from .chromium import Chromium
from .spatial_runs import PLANNERS, spatial_problems, spatial_run
from .views import open_view

STYLES = planner_styles(PLANNERS)
ABOVE, SIDE = PROJECTIONS[3]
Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> ReportData:
    return spatial_run(tmp_path_factory.mktemp("spatial"))


@pytest.fixture(scope="module")
def drawn(data: ReportData) -> dict[str, Scene]:
    return {scene.scenario: scene for scene in scenes(data, STYLES)}


def marks(panel: Panel, css: str) -> list[Mark]:
    return [mark for mark in panel.marks if mark.css == css]


def titled(panel: Panel, title: str) -> Mark:
    (mark,) = [mark for mark in panel.marks if mark.title == title]
    return mark


def places(mark: Mark) -> Array:
    """Corners of a polygon in the picture [px]."""
    return np.array(re.findall(r"-?[\d.]+", mark.d), dtype=float).reshape(-1, 2)


def in_metres(panel: Panel, pixels: Array) -> Array:
    """From places in a picture to the world, by the ticks that a reader has."""
    worlds = []
    for ticks, values in ((panel.x_ticks, pixels[:, 0]), (panel.y_ticks, pixels[:, 1])):
        at, labels = [tick.at for tick in ticks], [float(tick.label.replace("−", "-")) for tick in ticks]
        slope, offset = np.polyfit(at, labels, 1)
        worlds.append(slope * values + offset)
    return np.column_stack(worlds)


def test_there_are_two_views_with_every_planner(drawn: dict[str, Scene]) -> None:
    for scene in drawn.values():
        assert [(panel.title, panel.x_label, panel.y_label) for panel in scene.panels] == [
            ("seen from above", "x [m]", "y [m]"),
            ("seen from the side", "x [m]", "z [m]"),
        ]
        assert not scene.notes
        for panel in scene.panels:
            for css in ("path", "body final"):
                assert {mark.style.name for mark in marks(panel, css) if mark.style} == set(PLANNERS)
            assert len(marks(panel, "body start")) == 1


def test_obstacles_are_where_they_belong(drawn: dict[str, Scene]) -> None:
    above, side = drawn["point_3d/shapes"].panels
    for panel, place in ((above, [1.0, -1.5]), (side, [1.0, 0.0])):
        corners = in_metres(panel, places(titled(panel, "post")))
        assert 0.5 * (corners.min(axis=0) + corners.max(axis=0)) == pytest.approx(place, abs=0.02)
    assert np.ptp(in_metres(above, places(titled(above, "post"))), axis=0) == pytest.approx([0.4, 0.4], abs=0.03)
    assert np.ptp(in_metres(side, places(titled(side, "post"))), axis=0) == pytest.approx([0.4, 1.0], abs=0.03)
    for panel in (above, side):
        ball, scale = titled(panel, "ball"), in_metres(panel, np.array([[0.0, 0.0], [100.0, 0.0]]))
        radius = float(re.findall(r"a([\d.]+) ", ball.d)[0])
        assert radius * (scale[1, 0] - scale[0, 0]) / 100.0 == pytest.approx(0.3, abs=0.02)
        assert len(marks(panel, "track")) == 1
        assert len(marks(panel, "obstacle ghost")) == 4
        assert len(marks(panel, "goal")) == len(marks(panel, "tolerance")) == 1


def test_paths_are_projected(data: ReportData, drawn: dict[str, Scene]) -> None:
    trajectory = data.trajectory_of("scenarios/panda/wall.yaml::pd::seed0")
    path = trajectory.link("panda_hand")
    for panel, axes in zip(drawn["panda/wall"].panels, ([0, 1], [0, 2]), strict=True):
        (mark,) = [mark for mark in marks(panel, "path") if mark.style and mark.style.name == "pd"]
        seen = in_metres(panel, places(mark))
        assert seen[0] == pytest.approx(path[0, axes], abs=0.01)
        assert seen[-1] == pytest.approx(path[-1, axes], abs=0.01)


def test_a_collision_is_marked_where_it_happened(data: ReportData, drawn: dict[str, Scene]) -> None:
    trajectory = data.trajectory_of("scenarios/panda/wall.yaml::pd::seed0")
    assert trajectory.outcome == "collision"
    body = trajectory.columns["clearance_body"][-1]
    for panel, axes in zip(drawn["panda/wall"].panels, ([0, 1], [0, 2]), strict=True):
        crosses = [mark for mark in marks(panel, "collision") if mark.style and mark.style.name == "pd"]
        place = in_metres(panel, places(crosses[0])).mean(axis=0)
        assert np.linalg.norm(place - trajectory.link(body)[-1, axes]) < 0.2


def test_arms_have_a_skeleton_and_carts_a_heading(drawn: dict[str, Scene]) -> None:
    for panel in drawn["panda/wall"].panels:
        assert len(marks(panel, "skeleton ghost")) == 5 * len(PLANNERS)
        assert len(marks(panel, "skeleton start")) == 1
        assert not marks(panel, "body ghost")
    above, _ = drawn["cart/drive"].panels
    assert len(marks(above, "heading final")) == len(PLANNERS)
    assert not marks(above, "skeleton final")


def test_a_goal_that_leaves_an_axis_free_is_drawn_where_it_is_known(drawn: dict[str, Scene]) -> None:
    above, side = drawn["cart/drive"].panels
    assert len(marks(above, "goal")) == 1
    assert not marks(side, "goal")


def test_the_robot_is_inside_the_pictures(drawn: dict[str, Scene]) -> None:
    for scene in drawn.values():
        for panel in scene.panels:
            for mark in (*marks(panel, "body start"), *marks(panel, "skeleton start")):
                if "a" in mark.d:  # arcs
                    continue
                seen = places(mark)
                assert (seen >= (panel.left - 1, panel.top - 1)).all()
                assert (seen <= (panel.right + 1, panel.bottom + 1)).all()


def test_a_mesh_that_is_gone_is_left_out(tmp_path: Path) -> None:
    problems = spatial_problems(tmp_path)
    data = spatial_run(tmp_path, {"point_3d/shapes": problems["point_3d/shapes"]})
    for file in tmp_path.rglob("*.obj"):
        file.unlink()
    (scene,) = scenes(data, STYLES)
    for panel in scene.panels:
        assert not [mark for mark in panel.marks if mark.title == "ring"]
        assert titled(panel, "post").d


def test_a_report_of_both_kinds_is_the_same_again(data: ReportData) -> None:
    text = render(page(data))
    assert text == render(page(data))
    assert "seen from the side" in text
    assert ".skeleton" in text
    assert "nan" not in re.sub(r"<[^>]*title[^>]*>", "", "".join(re.findall(r' d="[^"]*"', text)))


def test_planar_reports_carry_nothing_of_it(html: str) -> None:
    for word in (".skeleton", "several", "seen from"):
        assert word not in html


def test_a_path_plot_has_the_obstacles(data: ReportData, tmp_path: Path) -> None:
    from matplotlib.figure import Figure

    from pytest_lpb.report.builtin_plots import path

    axes = Figure().add_subplot()
    path(data.trajectory_of("scenarios/point_3d/shapes.yaml::pd::seed0"), axes)
    assert len(axes.patches) == 6  # five obstacles and a tolerance
    assert "goal" in [text.get_text() for text in axes.get_legend().get_texts()]  # type: ignore[union-attr] # there is one


@given(arrays.arrays(np.float64, st.tuples(st.integers(1, 30), st.just(2)), elements=st.integers(-6, 6)))
def test_hulls_hold_all_points_with_corners_of_theirs(points: Array) -> None:
    hull = convex_hull(points)
    assert {tuple(corner) for corner in hull} <= {tuple(point) for point in points}
    if np.linalg.matrix_rank(points - points[0]) < 2:
        assert len(hull) <= 2
        assert np.ptp(hull, axis=0) == pytest.approx(np.ptp(points, axis=0))
        return
    expected = ConvexHull(points)
    assert {tuple(corner) for corner in hull} == {tuple(points[index]) for index in expected.vertices}
    area = 0.5 * np.sum(hull[:, 0] * np.roll(hull[:, 1], -1) - np.roll(hull[:, 0], -1) * hull[:, 1])
    assert area == pytest.approx(expected.volume)  # counter-clockwise


@pytest.fixture(scope="module")
def shapes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Obstacle]:
    """Obstacles by name."""
    problem = spatial_problems(tmp_path_factory.mktemp("shapes"))["point_3d/shapes"]
    return {obstacle.name: obstacle for obstacle in problem.obstacles}


@given(turn=st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(lambda q: sum(x * x for x in q) > 0.1))
def test_silhouettes_are_as_wide_as_the_bodies(shapes: dict[str, Obstacle], turn: list[float]) -> None:
    """Support functions: how far a body reaches in a direction."""
    quaternion = np.array(normalised(turn))
    rotation = matrix_of(quaternion.tolist())
    axis = rotation[:, 2]
    for projection in (ABOVE, SIDE):
        direction = np.zeros(3)
        direction[list(projection.axes)] = (0.6, 0.8)
        across = np.sqrt(1.0 - (axis @ direction) ** 2)
        expected: dict[str, float] = {
            "ball": 0.3,
            "crate": float(0.5 * np.abs(rotation.T @ direction) @ (0.4, 0.6, 0.8)),
            "post": float(0.2 * across + 0.5 * abs(axis @ direction)),
            "beam": float(0.1 + 0.5 * abs(axis @ direction)),
        }
        for name, reach in expected.items():
            outline = SpatialDepiction().outline(shapes[name], np.zeros(3), quaternion, projection)
            assert outline is not None
            if isinstance(outline, Disc):
                assert outline.radius == reach
                continue
            found = (outline @ (0.6, 0.8)).max()
            assert found <= reach + 1e-9
            assert found >= reach - 0.2 * (1.0 - np.cos(np.pi / RIM_POINTS)) - 1e-9


def test_a_silhouette_of_a_ball_is_a_disc(shapes: dict[str, Obstacle]) -> None:
    placed = solid_of(geometry_of(shapes["ball"])).placed(
        pose_from(np.array([1.0, 2.0, 3.0]), np.array([1.0, 0.0, 0.0, 0.0]))
    )
    outline = silhouette(placed, SIDE)
    assert isinstance(outline, Disc)
    assert outline.centre.tolist() == [1.0, 3.0]
    assert corners_of(outline).tolist() == [[0.7, 2.7], [1.3, 2.7], [1.3, 3.3], [0.7, 3.3]]


@pytest.mark.chromium
@pytest.mark.parametrize(("width", "beside"), [(1280, True), (390, False)])
def test_the_views_stand_side_by_side_where_there_is_room(
    browser: Chromium, data: ReportData, tmp_path: Path, width: int, *, beside: bool
) -> None:
    address = write_report(tmp_path / "report.html", data).as_uri()
    browser.look(width, 900, "light", phone=width < 500)
    open_view(browser, address, "#/scenarios")
    assert browser.errors == []
    assert browser.run("document.documentElement.scrollWidth") <= width
    boxes = browser.run(
        "[...document.querySelectorAll('.scene')[0].querySelectorAll('.scene-svg')]"
        ".map(svg => svg.getBoundingClientRect()).map(r => [r.left, r.top, r.width])"
    )
    (first_left, first_top, first_width), (second_left, second_top, second_width) = boxes
    assert first_width == pytest.approx(second_width, abs=1.0)
    assert (second_left > first_left + first_width) == beside
    assert (second_top == first_top) == beside
