"""Study files."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_lpb.documents.recognition import is_study
from pytest_lpb.errors import ConfigurationError, ScenarioError
from pytest_lpb.planner.files import find_planners
from pytest_lpb.study.study import Study, read_study
from pytest_lpb.study.sweep import planner_variants, suffix

SCENARIO = """\
version: 1
robot: {model: point, body_radius: 0.2}
goal: [{type: position, link: body, target: [0.05, 0.0], tolerance: 0.1}]
"""
BEGINNING = "study: s\nplanners: [pd]\nscenarios: x.yaml\n"


def study(folder: Path, text: str) -> Study:
    (folder / "x.yaml").write_text(SCENARIO)
    path = folder / "study.yaml"
    path.write_text(text)
    return read_study(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("study: s\nplanners: []\nscenarios: x.yaml\n", "study.yaml:2: planners: found a list of 0; at least 1 entry"),
        ("study: s\nscenarios: x.yaml\n", "planners: is missing"),
        (BEGINNING + "trails: 3\n", "study.yaml:4: trails: unknown key; did you mean 'trials'?"),
        (BEGINNING + "trials: 0\n", "study.yaml:4: trials: found 0; allowed: at least 1"),
        (BEGINNING + "verdict: some\n", "study.yaml:4: verdict: found the text 'some'; allowed: trial, rate, none"),
        (BEGINNING + "random: [walls]\n", "allowed: start, goal, obstacles"),
        (BEGINNING + "sweep: [{planner: pd}]\n", "study.yaml:4: sweep[0]: a sweep has either"),
        (
            BEGINNING + "sweep: [{planner: pd, parameters: {p: [1]}, knobs: {obstacle_count: [1]}}]\n",
            "a sweep has either",
        ),
        (BEGINNING + "sweep: [{knobs: {'a b': [1]}}]\n", "found 'a b'; a key path such as"),
        (BEGINNING + "sweep: [{planner: pd, parameters: {p: [1, 1]}}]\n", "found 1 twice"),
        ("- study\n", "study.yaml:1: found a list; a study is a mapping"),
        ("study: [\n", "not YAML"),
    ],
)
def test_faults_are_told_with_their_places(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        study(tmp_path, text)
    assert message in str(caught.value)


def test_scenarios_that_are_not_there(tmp_path: Path) -> None:
    made = study(tmp_path, BEGINNING.replace("x.yaml", "y*.yaml"))
    with pytest.raises(
        ConfigurationError, match=r"study.yaml:3: scenarios\[0\]: found 'y\*.yaml'; no scenario file matches"
    ):
        made.families(lambda path: path.stem)


def test_globs_find_no_studies(tmp_path: Path) -> None:
    made = study(tmp_path, BEGINNING.replace("x.yaml", "['*.yaml', 'x.yaml']"))
    assert [family.key for family in made.families(lambda path: path.stem)] == ["x"]
    assert is_study(tmp_path / "study.yaml")
    assert not is_study(tmp_path / "x.yaml")


def test_planners_that_are_not_the_studys(tmp_path: Path) -> None:
    made = study(tmp_path, BEGINNING + "sweep: [{planner: pdd, parameters: {p: [1.0]}}]\n")
    with pytest.raises(ConfigurationError, match="found 'pdd'; did you mean 'pd'"):
        made.planners(find_planners(["pd"], []))


def test_sweeps_of_planners_that_the_command_line_leaves_out(tmp_path: Path) -> None:
    made = study(tmp_path, BEGINNING + "sweep: [{planner: pd, parameters: {p: [1.0, 2.0]}}]\n")
    assert [planner.name for planner in made.planners(find_planners(["potential_field"], []))] == ["potential_field"]


def test_a_studys_folder_may_be_called_anything(tmp_path: Path) -> None:
    folder = tmp_path / "a [b] *"
    folder.mkdir()
    made = study(folder, BEGINNING)
    assert [family.path for family in made.families(lambda path: path.stem)] == [folder / "x.yaml"]
    absolute = study(folder, BEGINNING.replace("x.yaml", f"'{tmp_path}/a*/x.yaml'"))
    assert [family.path for family in absolute.families(lambda path: path.stem)] == [folder / "x.yaml"]


@pytest.mark.parametrize(
    ("value", "end"), [(-0.5, "_p--0.5"), ("-a b", "_p-a-b"), ([-1, 2], "_p-1-2"), ("x/y", "_p-x-y"), (None, "_p-null")]
)
def test_values_in_names(value: object, end: str) -> None:
    assert suffix({"p": value}) == end


def test_every_combination_has_its_name(tmp_path: Path) -> None:
    made = study(tmp_path, BEGINNING + "sweep: [{planner: pd, parameters: {p: [1.0, 2.0], derivative: [velocity]}}]\n")
    planners = made.planners(find_planners(["pd"], []))
    assert [planner.name for planner in planners] == ["pd_p-1.0_derivative-velocity", "pd_p-2.0_derivative-velocity"]
    assert [planner.parameters["p"] for planner in planners] == [1.0, 2.0]
    assert len({planner.parameters_hash for planner in planners}) == 2
    swept = made.swept(made.families(lambda path: path.stem))
    assert swept["planners"]["pd_p-2.0_derivative-velocity"] == {
        "of": "pd",
        "values": {"p": 2.0, "derivative": "velocity"},
    }


def test_sweeps_go_before_what_a_planner_has_for_single_robots(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("planner: pd\nper_robot: {point: {p: 9.0, k: 4.0}}\n")
    (planner,) = find_planners([str(path)], [])
    (variant,) = planner_variants(planner, {"p": [2.0]})
    parameters = variant.parameters_for("point", "acceleration")
    assert (parameters.p, parameters.k) == (2.0, 4.0)


def test_parameters_that_the_planner_lacks(tmp_path: Path) -> None:
    made = study(tmp_path, BEGINNING + "sweep: [{planner: pd, parameters: {q: [1.0]}}]\n")
    with pytest.raises(ConfigurationError, match=r"study.yaml:4: sweep\[0\].parameters: .*unknown parameter"):
        made.planners(find_planners(["pd"], []))


def test_scenarios_with_every_combination_of_knobs(tmp_path: Path) -> None:
    made = study(tmp_path, BEGINNING + "sweep: [{knobs: {robot.body_radius: [0.1, 0.2], environment.dt: [0.05]}}]\n")
    families = made.families(lambda path: path.stem)
    assert [family.key for family in families] == [
        "x_robot.body_radius-0.1_environment.dt-0.05",
        "x_robot.body_radius-0.2_environment.dt-0.05",
    ]
    assert [family.scenario().concrete["robot"]["body_radius"] for family in families] == [0.1, 0.2]
    assert families[0].description()["changes"] == {"robot.body_radius": 0.1, "environment.dt": 0.05}


def test_values_that_make_no_scenario(tmp_path: Path) -> None:
    made = study(tmp_path, BEGINNING + "sweep: [{knobs: {robot.body_radius: [-0.1]}}]\n")
    (family,) = made.families(lambda path: path.stem)
    with pytest.raises(
        ScenarioError, match=r"study.yaml:4: sweep\[0\].knobs: with robot.body_radius: -0.1 it is no scenario"
    ):
        family.scenario()


def test_sweeps_of_scenarios_that_the_study_lacks(tmp_path: Path) -> None:
    made = study(tmp_path, BEGINNING + "sweep: [{scenarios: y, knobs: {environment.dt: [0.01]}}]\n")
    with pytest.raises(ConfigurationError, match="found y; the study's scenarios are x"):
        made.families(lambda path: path.stem)
