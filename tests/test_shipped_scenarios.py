"""The scenarios that ship with the package: right, feasible, described, and drawn alike whatever else they say."""

import re
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import yaml

from pytest_lpb.documents.recognition import is_study
from pytest_lpb.errors import MissingRobotsError
from pytest_lpb.plugin.collection import STANDARD_TAGS
from pytest_lpb.problem.paths import with_absolute_paths
from pytest_lpb.scenario.draw import check_feasible, draw_problem
from pytest_lpb.scenario.feasibility import is_free
from pytest_lpb.scenario.load import Scenario, load_scenario
from pytest_lpb.shipped import shipped_folder

FOLDER = shipped_folder("scenarios")
PATHS = sorted(path for path in FOLDER.rglob("*.yaml") if not is_study(path))
MODELS = {"point": "point", "planar_arm": "arm", "differential_drive": "differential_drive"}
SPATIAL_MODELS = {
    "point_3d": "point",
    "cart": "differential_drive",
    "husky": "differential_drive",
    "car": "bicycle",
    "racecar": "bicycle",
    **dict.fromkeys(("arm_3d", "panda", "kuka_iiwa", "xarm6", "ur5"), "arm"),
}
MOBILE = "mobile_manipulator"

pytestmark = pytest.mark.filterwarnings("error")
each_path = pytest.mark.parametrize(
    "path", PATHS, ids=[path.relative_to(FOLDER).with_suffix("").as_posix() for path in PATHS]
)


def test_there_are_scenarios_of_every_robot() -> None:
    assert {path.parent.name for path in PATHS} >= set(MODELS)
    assert len(PATHS) >= 20


def tags_of(robot: dict[str, Any]) -> set[str]:
    """Tags that say what robot it is."""
    model = robot["model"]
    if model in MODELS:
        return {"planar", MODELS[model]}
    if SPATIAL_MODELS[model] == "arm" and robot["base"] != "fixed":
        return {"spatial", MOBILE}
    return {"spatial", SPATIAL_MODELS[model]}


def loaded(path: Path) -> Scenario:
    """A shipped scenario; skips the test where its robot's package is not installed."""
    try:
        return load_scenario(path)
    except MissingRobotsError as error:
        pytest.skip(str(error))


@each_path
def test_it_is_described_and_tagged_by_what_it_holds(path: Path) -> None:
    scenario = loaded(path)
    entry = scenario.concrete
    assert scenario.description.endswith(".")
    assert set(scenario.tags) <= set(STANDARD_TAGS)
    assert tags_of(entry["robot"]) <= set(scenario.tags)
    assert ("random" in scenario.tags) == bool(scenario.draw)
    assert ("velocity" in scenario.tags) == (entry["robot"]["control"] == "velocity")
    moves = any("target" not in goal for goal in entry["goal"] if goal["type"] != "alignment")
    moves = moves or any("position" not in obstacle for obstacle in entry["obstacles"])
    assert ("moving" in scenario.tags, "static" in scenario.tags) == (moves, not moves)


@each_path
def test_random_ones_have_several_trials_and_others_one(path: Path) -> None:
    scenario = loaded(path)
    assert 5 <= scenario.trials <= 10 if scenario.draw else scenario.trials == 1


@each_path
def test_it_is_feasible_also_when_all_its_ranges_are_drawn_from(path: Path) -> None:
    scenario = loaded(path)
    check_feasible(scenario)
    for seed in range(3):
        for flags in ((), ("start", "goal", "obstacles")):
            problem = draw_problem(scenario, seed, flags)
            with closing(problem.robot.collision_space(problem.obstacles)) as space:
                assert is_free(space, problem.start_q.tolist(), 0.0)


def hashes(scenario: Scenario) -> list[str]:
    return [draw_problem(scenario, seed).problem_hash for seed in range(3)]


@each_path
def test_problems_do_not_depend_on_comments_tags_and_known_failures(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LPB_ALLOW_PATHS", str(FOLDER))  # where its meshes and certified paths stay
    data = with_absolute_paths(yaml.safe_load(path.read_text()), path.parent)
    data |= {"tags": ["other"], "xfail": {"mine": "no reason"}, "description": "Another.", "trials": 3}
    changed = tmp_path / path.name
    changed.write_text("# another comment\n" + yaml.safe_dump(data))
    scenario = loaded(path)
    assert hashes(load_scenario(changed)) == hashes(scenario)
    assert len(set(hashes(scenario))) == (3 if scenario.draw else 1)


@each_path
def test_known_failures_name_shipped_planners_and_seeds_that_run(path: Path) -> None:
    scenario = loaded(path)
    seeds = range(scenario.seed, scenario.seed + scenario.trials)
    for planner, known in scenario.xfail.items():
        assert (shipped_folder("planners") / f"{planner}.yaml").is_file()
        assert known.reason
        assert known.outcomes
        assert set(known.seeds or seeds) <= set(seeds)
        assert not set(known.outcomes) & {"success", "planner_error", "environment_error", "deadline", "worker_crash"}


def test_the_page_on_scenarios_lists_each_and_its_example_loads(tmp_path: Path) -> None:
    page = (Path(__file__).parents[1] / "docs/scenarios.md").read_text("utf-8")
    rows = re.findall(r"^\| `([^`]+)` \| ([^|]+) \| (\d+) \|", page, re.MULTILINE)
    shipped = []
    for path in PATHS:
        data = yaml.safe_load(path.read_text())
        tags = ", ".join(tag for tag in data["tags"] if tag != "planar")
        shipped.append((path.relative_to(FOLDER).with_suffix("").as_posix(), tags, str(data.get("trials", 1))))
    assert sorted(rows) == sorted(shipped)
    example = tmp_path / "example.yaml"
    example.write_text(page.split("```yaml\n")[1].split("```")[0])
    scenario = load_scenario(example)
    check_feasible(scenario)
    draw_problem(scenario, 0)
