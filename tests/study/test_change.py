"""Changes of scenarios that sweeps ask for."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion import parse_expression
from pytest_lpb.study.change import Change, check_name

GROUP = {"count": [2, 4], "shape": "circle", "position": [[0, 1], [0, 1]], "radius": 0.2, "velocity": [[-1, 1], [0, 2]]}
DATA: dict[str, Any] = {
    "robot": {"model": "point"},
    "obstacles": [
        {"shape": "circle", "radius": 0.5, "trajectory": ["tan(t) + exp(t)", "1"]},
        {"shape": "rectangle", "size": [1.0, 2.0], "spline": [[1.0, 0.0, 0.0], [3.0, 1.0, 1.0]], "periodic": True},
    ],
    "randomize": {"obstacles": GROUP},
}


def changed(name: str, value: Any, data: dict[str, Any] = DATA) -> dict[str, Any]:
    before = copy.deepcopy(data)
    result = Change(name, value).apply(data)
    assert data == before
    return result


@pytest.mark.parametrize(
    ("path", "value"),
    [("robot.body_radius", 0.3), ("obstacles[0].radius", 0.7), ("environment.dt", 0.01), ("obstacles[1].size[0]", 9.0)],
)
def test_values_at_key_paths(path: str, value: float) -> None:
    result = changed(path, value)
    found: Any = result
    for step in path.replace("[", ".").replace("]", "").split("."):
        found = found[int(step) if step.isdigit() else step]
    assert found == value


@pytest.mark.parametrize("path", ["obstacles[7].radius", "robot.model.radius", "nothing[0].x", "robot[0]"])
def test_places_that_are_not_there(path: str) -> None:
    with pytest.raises(ScenarioError, match="this scenario has no such place"):
        changed(path, 1.0)


@pytest.mark.parametrize("name", ["robot..x", "", "obstacles[a]", "x y", "obstacles[0"])
def test_names_that_are_no_key_paths(name: str) -> None:
    with pytest.raises(ScenarioError, match="a key path such as"):
        check_name(name)


@pytest.mark.parametrize("factor", [0.0, 0.5, 3.0])
def test_faster_obstacles_are_where_they_would_be_later(factor: float) -> None:
    result = changed("obstacle_speed_factor", factor)
    times = np.array([0.1, 0.4])
    before = parse_expression("tan(t) + exp(t)").evaluate(factor * times)
    after = parse_expression(result["obstacles"][0]["trajectory"][0]).evaluate(times)
    assert after[0] == pytest.approx(before[0], abs=1e-12)
    assert after[1] == pytest.approx(factor * before[1], abs=1e-12)
    assert result["randomize"]["obstacles"]["velocity"] == [[-factor, factor], [0, 2 * factor]]


def test_splines_are_run_through_faster_or_not_at_all() -> None:
    assert changed("obstacle_speed_factor", 2.0)["obstacles"][1]["spline"] == [[0.5, 0.0, 0.0], [1.5, 1.0, 1.0]]
    still = changed("obstacle_speed_factor", 0)["obstacles"][1]
    assert still["position"] == [0.0, 0.0]
    assert "spline" not in still
    assert "periodic" not in still


def test_clearance_is_taken_off_obstacles() -> None:
    result = changed("clearance_change_m", 0.1)
    assert result["obstacles"][0]["radius"] == pytest.approx(0.4)
    assert result["obstacles"][1]["size"] == pytest.approx([0.8, 1.8])
    assert result["randomize"]["obstacles"]["radius"] == pytest.approx(0.1)


def test_meshes_have_no_clearance_to_change() -> None:
    with pytest.raises(ScenarioError, match="shape 'mesh' has no radius or size"):
        changed("clearance_change_m", 0.1, {"obstacles": [{"shape": "mesh", "file": "x.stl"}]})


def test_the_number_of_drawn_obstacles() -> None:
    result = changed("obstacle_count", 7)
    assert result["randomize"]["obstacles"]["count"] == 7
    assert result["randomize"]["draw"] == ["obstacles"]


def test_a_number_shared_by_groups() -> None:
    data = {"randomize": {"obstacles": [{**GROUP, "count": 1}, {**GROUP, "count": [1, 3]}, {**GROUP, "count": 1}]}}
    result = changed("obstacle_count", 7, data)
    counts = [group["count"] for group in result["randomize"]["obstacles"]]
    assert counts == [2, 3, 2]
    with pytest.raises(ScenarioError, match="with several groups a whole number is required"):
        changed("obstacle_count", [1, 2], data)


def test_nothing_to_count() -> None:
    with pytest.raises(ScenarioError, match="draws no obstacles"):
        changed("obstacle_count", 7, {"robot": {}})


@pytest.mark.parametrize("value", [-1.0, True, "fast"])
def test_speeds_that_are_none(value: Any) -> None:
    with pytest.raises(ScenarioError, match="a number of at least 0 is required"):
        changed("obstacle_speed_factor", value)
