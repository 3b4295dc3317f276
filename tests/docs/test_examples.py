"""The examples in README and docs/ run as they stand there."""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pytest_lpb.problem.robot import robot_from
from pytest_lpb.scenario.draw import check_feasible, draw_problem
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.scenario.schema.robot import Robot
from pytest_lpb.scenario.spatial import SpatialDescription, spatial_models

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


AWAY = """
from pytest_lpb import Planner


class Away(Planner):
    name = "away"

    def compute_action(self, observation):
        return 2.0 * (0.7 - observation["q"]) - 3.0 * observation["qd"]
"""


def blocks(page: str, language: str) -> list[str]:
    return [text for kind, text in BLOCK.findall((ROOT / page).read_text("utf-8")) if kind == language]


@pytest.fixture
def repository(pytester: pytest.Pytester) -> pytest.Pytester:
    """A planner repository with README's planner and scenario."""
    pytester.makepyfile(my_planner=blocks("README.md", "python")[0])
    pytester.mkdir("planners")
    (pytester.path / "planners/mine.yaml").write_text("planner: my_planner:TowardsGoal\n", "utf-8")
    (pytester.path / "scenarios/point").mkdir(parents=True)
    (pytester.path / "scenarios/disc.yaml").write_text(blocks("README.md", "yaml")[0], "utf-8")
    return pytester


def test_readme_planner_and_scenario(repository: pytest.Pytester) -> None:
    toml = blocks("README.md", "toml")[0]
    (repository.path / "pyproject.toml").write_text(toml, "utf-8")
    result = repository.runpytest_subprocess("-rA")
    result.stdout.fnmatch_lines(["*scenarios/disc.yaml::mine::seed0*"])
    result.assert_outcomes(xfailed=1)


def test_readme_commands_are_the_ones_ci_runs() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    commands = re.findall(r"^    (pip install -e .*)$", text, re.MULTILINE)
    assert commands == [
        "pip install -e '.[test]' && pytest --lpb-planners=fabrics,mpc -n 2 scenarios/",
        "pip install -e '.[test]' && pytest",
    ]


def test_planner_file(repository: pytest.Pytester) -> None:
    (repository.path / "planners/mine.yaml").write_text(blocks("docs/extending.md", "yaml")[0], "utf-8")
    repository.runpytest_subprocess("--lpb-planners=mine").assert_outcomes(xfailed=1)


def test_kpi_and_plot(repository: pytest.Pytester) -> None:
    kpi, plot, *_ = blocks("docs/extending.md", "python")
    repository.makepyfile(my_plugins=f"{kpi}\n{plot}")
    repository.makeini("[pytest]\nlpb_plugins = my_plugins\n")
    repository.runpytest_subprocess("--lpb-planners=mine").assert_outcomes(xfailed=1)
    assert ",height_max_m" in (repository.path / "reports/latest/trials.csv").read_text("utf-8")
    result = repository.run(str(Path(sys.executable).with_name("lpb-report")), "reports/latest", "--plot", "height")
    assert result.ret == 0
    assert list((repository.path / "reports/latest/plots").rglob("*.png"))


@pytest.mark.parametrize("page", ["docs/extending.md", "docs/environment.md", "docs/library.md", "docs/reports.md"])
def test_script(page: str, repository: pytest.Pytester) -> None:
    scenario = repository.path / "scenarios/point/two_circles.yaml"
    shutil.copy(ROOT / "scenarios/point/two_circles.yaml", scenario)
    assert repository.runpytest_subprocess("--lpb-planners=mine", "--lpb-assert=none").ret == 0
    scripts = blocks(page, "python")
    script = repository.makepyfile(example="\n".join(scripts[-1:] if page == "docs/extending.md" else scripts))
    result = repository.runpython(script)
    assert result.ret == 0
    assert result.outlines, "the example prints what it found"


def test_a_shape_and_a_type_of_sub_goal(repository: pytest.Pytester) -> None:
    (repository.path / "scenarios/disc.yaml").write_text(blocks("docs/extending.md", "yaml")[1], "utf-8")
    repository.makeconftest(f"{blocks('docs/extending.md', 'python')[2]}\n\n{AWAY}")
    repository.runpytest_subprocess("--lpb-planners=away", "--lpb-trials=2").assert_outcomes(passed=2)


def test_kinematics_of_the_page_on_robots(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    found: dict[str, object] = {}
    exec(blocks("docs/robots.md", "python")[0], found)
    pose: Any = found["pose"]
    np.testing.assert_allclose(np.array(found["value"])[:, 0], pose[:3, 3], atol=1e-12)


def test_robots_and_scenario_in_space_load(tmp_path: Path) -> None:
    path = tmp_path / "beam.yaml"
    path.write_text(next(text for text in blocks("docs/scenarios.md", "yaml") if "pybullet" in text), "utf-8")
    scenario = load_scenario(path)
    check_feasible(scenario)
    assert len(draw_problem(scenario, 0, ("obstacles",)).obstacles) > 3
    mobile = yaml.safe_load(next(text for text in blocks("docs/robots.md", "yaml") if "base_size" in text))
    description = SpatialDescription(Robot.model_validate(mobile["robot"]))
    assert description.structure.actions[:2] == ("v", "w")
    robot = robot_from(description.entry)
    assert robot.action_map(np.zeros(robot.dof)).shape == (10, 9)  # as the page says


def test_robots_that_are_named_are_those_there_are() -> None:
    for page in ("README.md", "docs/robots.md"):
        rows = [line for line in (ROOT / page).read_text("utf-8").splitlines() if line.startswith("|")]
        named = {name for line in rows for name in re.findall(r"`(\w+)`", line)}
        assert set(spatial_models()) <= named, page


def test_each_page_is_found_from_the_readme() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    assert {f"docs/{page.name}" for page in (ROOT / "docs").glob("*.md")} <= set(
        re.findall(r"\((docs/[\w-]+\.md)\)", text)
    )


def anchors(page: Path) -> set[str]:
    """Of a page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", ["README.md", *(f"docs/{page.name}" for page in sorted((ROOT / "docs").glob("*.md")))])
def test_links_lead_somewhere(page: str) -> None:
    for target in re.findall(r"\]\((?!https?:)([^)\s]+)\)", (ROOT / page).read_text("utf-8")):
        name, _, anchor = target.partition("#")
        linked = (ROOT / page).parent / name if name else ROOT / page
        assert linked.is_file(), target
        assert not anchor or anchor in anchors(linked), target


def test_study(repository: pytest.Pytester) -> None:
    shutil.copytree(ROOT / "scenarios/point", repository.path / "scenarios/point", dirs_exist_ok=True)
    (repository.path / "studies").mkdir()
    (repository.path / "studies/study.yaml").write_text(blocks("docs/studies.md", "yaml")[0], "utf-8")
    result = repository.runpytest_subprocess("studies/study.yaml", "--collect-only", "-q")
    result.stdout.fnmatch_lines(["studies/study.yaml::point/clutter_obstacle_count-8::mpc_horizon-20::seed19"])
    selected = "clutter_obstacle_count-4 and (fabrics or horizon-10)"
    result = repository.runpytest_subprocess("studies/study.yaml", "--lpb-trials=1", "-k", selected)
    result.assert_outcomes(passed=2)
    result.stdout.fnmatch_lines(["*mpc_horizon-10*", "*inconclusive*"])


def test_commands_of_a_gate(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    (pytester.path / "scenarios").mkdir()
    shutil.copy(ROOT / "scenarios/point/clutter.yaml", pytester.path / "scenarios")
    for key in [key for key in os.environ if key.startswith(("PYTEST_", "COV_"))]:
        monkeypatch.delenv(key)
    (commands,) = blocks("docs/gates.md", "sh")
    folder = str(Path(sys.executable).parent)
    monkeypatch.setenv("PATH", folder, prepend=os.pathsep)
    for command in commands.splitlines():
        result = pytester.run("sh", "-c", command)
        assert result.ret == 0, command
    assert (pytester.path / "baseline.json").is_file()
    assert "**gate open: same or better in all that was asked**" in (pytester.path / "summary.md").read_text("utf-8")


def test_script_of_a_gate(pytester: pytest.Pytester) -> None:
    (script,) = blocks("docs/gates.md", "python")
    result = pytester.runpython(pytester.makepyfile(example=script))
    assert result.ret == 0
    result.stdout.re_match_lines([r"loss 0\.025, -0\.0\d+ to 0\.\d+", r"problems that would decide: \d+"])
