"""Study files, run by naming them."""

from __future__ import annotations

import pytest

from .projects import DRAWN, SCENARIO, UNSOLVED, Project, node_ids, read_run, text_of, trial_files

STUDY = """\
study: two planners
planners: [pd, potential_field]
scenarios: ../scenarios/**/*.yaml
trials: 2
seed: 3
kpis: [time_to_goal_s]
"""
SWEEP = (
    STUDY
    + """\
sweep:
  - {planner: pd, parameters: {p: [1.0, 2.0]}}
  - {scenarios: a/drawn, knobs: {robot.body_radius: [0.1, 0.2]}}
"""
)


@pytest.fixture
def prepared(project: Project) -> Project:
    project.scenario("scenarios/a/drawn.yaml", DRAWN)
    project.scenario("scenarios/b/unsolved.yaml", UNSOLVED)
    project.write("studies/study.yaml", STUDY)
    return project


def test_a_study_is_run_by_its_name(prepared: Project) -> None:
    result = prepared.run("studies/study.yaml", planners=None)
    assert result.ret == 0, text_of(result)  # a study measures: what is not solved fails nothing
    keys = [(row["scenario"], row["planner"], row["seed"]) for row in prepared.rows()]
    assert len(keys) == 2 * 2 * 2
    assert {key[0] for key in keys} == {"a/drawn", "b/unsolved"}
    assert {key[2] for key in keys} == {"3", "4"}
    assert "time_to_goal_s" in prepared.rows()[0]
    assert "clearance_min_m" not in prepared.rows()[0]


def test_node_ids_select(prepared: Project) -> None:
    listed = node_ids(prepared.run("studies/study.yaml", "--collect-only", "-q", planners=None))
    assert listed[0] == "studies/study.yaml::a/drawn::pd::seed3"
    assert len(listed) == 8
    for node_id in (listed[0], "studies/study.yaml::b/unsolved::potential_field"):
        prepared.run(node_id, planners=None)
        assert all(row["node_id"].startswith(node_id) for row in prepared.rows())
    prepared.run("studies/study.yaml", "-k", "drawn and seed4 and not pd", planners=None)
    assert prepared.row()["node_id"] == "studies/study.yaml::a/drawn::potential_field::seed4"


def test_with_workers(prepared: Project) -> None:
    prepared.write("studies/study.yaml", SWEEP)
    prepared.run("studies/study.yaml", planners=None)
    alone = prepared.hashes()
    result = prepared.run_workers("studies/study.yaml", planners=None)
    assert result.ret == 0, text_of(result)
    assert prepared.hashes() == alone
    assert len(alone) == 3 * 3 * 2


def test_options_go_before_the_study(prepared: Project) -> None:
    result = prepared.run("studies/study.yaml", "--lpb-trials=1", "--lpb-assert=trial", planners="pd")
    assert result.ret == 1
    assert [(row["scenario"], row["planner"], row["seed"]) for row in prepared.rows()] == [
        ("a/drawn", "pd", "3"),
        ("b/unsolved", "pd", "3"),
    ]
    (command,) = [line for line in dict.fromkeys(result.stdout.lines) if line.startswith("repeat: ")]
    arguments = command.removeprefix("repeat: pytest ").split()
    before = prepared.hashes()["b/unsolved", "pd", "3"]
    prepared.run(*arguments, planners=None)
    assert list(prepared.hashes().values()) == [before]


def test_variants_are_told_apart(prepared: Project) -> None:
    prepared.write("studies/study.yaml", SWEEP)
    result = prepared.run("studies/study.yaml", planners=None)
    assert result.ret == 0, text_of(result)
    run = prepared.runs()[-1]
    info = read_run(run)
    assert sorted(info["planners"]) == ["pd_p-1.0", "pd_p-2.0", "potential_field"]
    assert [info["planners"][name]["parameters"]["p"] for name in ("pd_p-1.0", "pd_p-2.0")] == [1.0, 2.0]
    assert info["swept"]["planners"]["pd_p-2.0"] == {"of": "pd", "values": {"p": 2.0}}
    variants = info["swept"]["scenarios"]
    assert variants["a/drawn_robot.body_radius-0.1"] == {"of": "a/drawn", "values": {"robot.body_radius": 0.1}}
    assert info["scenarios"]["a/drawn_robot.body_radius-0.1"]["changes"] == {"robot.body_radius": 0.1}
    assert "a/drawn_robot.body_radius-0.1/pd_p-1.0/seed3.parquet" in trial_files(run)
    of_two = {
        row["problem_hash"] for row in prepared.rows() if row["scenario"].startswith("a/drawn") and row["seed"] == "3"
    }
    assert len(of_two) == 2  # one per radius


def test_a_study_is_found_by_its_name_only(prepared: Project) -> None:
    prepared.write("scenarios/a/study.yaml", STUDY.replace("../scenarios", ".."))
    result = prepared.run("scenarios", "--collect-only", "-q")
    assert not [node_id for node_id in node_ids(result) if "study" in node_id], text_of(result)


def test_a_study_is_run_by_itself(prepared: Project) -> None:
    result = prepared.run("studies/study.yaml", "scenarios", planners=None)
    assert result.ret == 4
    assert "a study is run by itself: study.yaml and scenarios are named" in text_of(result)


@pytest.mark.parametrize("workers", [0, 2])
def test_a_wrong_study_is_a_usage_error(prepared: Project, workers: int) -> None:
    prepared.write("studies/study.yaml", STUDY + "trails: 2\n")
    result = prepared.run("-n", str(workers), "studies/study.yaml", planners=None)
    assert result.ret == 4
    assert "studies/study.yaml:7: trails: unknown key; did you mean 'trials'?" in text_of(result)
    assert not prepared.runs()


def test_values_that_make_no_scenario(prepared: Project) -> None:
    prepared.write("studies/study.yaml", SWEEP.replace("[0.1, 0.2]", "[0.1, -0.2]"))
    result = prepared.run("studies/study.yaml", planners=None)
    assert result.ret == 2
    assert "studies/study.yaml:9: sweep[1].knobs: with robot.body_radius: -0.2 it is no scenario:" in text_of(result)


def test_order_changes_nothing(prepared: Project) -> None:
    prepared.run("studies/study.yaml", planners=None)
    before = prepared.hashes()
    text = STUDY.replace("[pd, potential_field]", "[potential_field, pd]")
    text = text.replace("../scenarios/**/*.yaml", "[../scenarios/b/unsolved.yaml, ../scenarios/a/drawn.yaml]")
    prepared.write("studies/study.yaml", text)
    prepared.run_workers("studies/study.yaml", planners=None)
    assert prepared.hashes() == before
    first, second = (run / "summary.csv" for run in prepared.runs())
    assert first.read_text() == second.read_text()


def test_a_crash_in_a_study(prepared: Project) -> None:
    prepared.write(
        "conftest.py",
        "import os\nfrom pytest_lpb import Planner\n\nclass Dead(Planner):\n    name = 'dead'\n\n"
        "    def setup(self, problem):\n        pass\n\n"
        "    def compute_action(self, observation):\n        os._exit(3)\n",
    )
    prepared.scenario("scenarios/a/drawn.yaml", SCENARIO)
    prepared.write("studies/study.yaml", STUDY.replace("[pd, potential_field]", "[pd, dead]").replace("trials: 2", ""))
    result = prepared.run_workers("studies/study.yaml", planners=None)
    assert result.ret == 1
    outcomes = {(row["scenario"], row["planner"]): row["outcome"] for row in prepared.rows()}
    assert outcomes["a/drawn", "dead"] == outcomes["b/unsolved", "dead"] == "worker_crash"
    assert outcomes["a/drawn", "pd"] == "success"
