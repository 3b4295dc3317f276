"""The tree of items: node ids and how to select among them."""

from __future__ import annotations

import pytest

from .projects import UNSOLVED, Project, node_ids, text_of

LISTED = [
    f"scenarios/point/{name}.yaml::{planner}::seed{seed}"
    for name in ("x", "y")
    for planner in ("pd", "potential_field")
    for seed in (0, 1)
]


@pytest.fixture
def both(project: Project) -> Project:
    project.scenario()
    project.scenario("scenarios/point/y.yaml", UNSOLVED.replace("[planar]", "[planar, narrow]"))
    return project


def collected(project: Project, *arguments: str) -> list[str]:
    result = project.run("--lpb-trials=2", "--collect-only", "-q", *arguments, planners="pd,potential_field")
    assert project.runs() == []
    return node_ids(result)


def test_node_ids_are_file_planner_seed(both: Project) -> None:
    assert collected(both, "scenarios") == LISTED


def test_a_node_id_selects_one_trial(both: Project) -> None:
    assert collected(both, LISTED[3]) == [LISTED[3]]


def test_a_planner_of_a_file_selects_its_trials(both: Project) -> None:
    assert collected(both, "scenarios/point/y.yaml::pd") == LISTED[4:6]


def test_keywords_select(both: Project) -> None:
    assert collected(both, "-k", "x.yaml and pd and seed1", "scenarios") == [LISTED[1]]


@pytest.mark.parametrize(("tag", "expected"), [("narrow", LISTED[4:]), ("planar", LISTED), ("not planar", [])])
def test_tags_are_markers(both: Project, tag: str, expected: list[str]) -> None:
    assert collected(both, "-m", tag, "scenarios") == expected


def test_deselect(both: Project) -> None:
    arguments = ("--deselect", "scenarios/point/x.yaml", "--deselect", LISTED[7], "scenarios")
    assert collected(both, *arguments) == LISTED[4:7]


def test_a_file_named_twice_is_collected_once(both: Project) -> None:
    assert collected(both, "scenarios", "scenarios/point/x.yaml", "scenarios/point/x.yaml") == LISTED


def test_last_failed_runs_the_failed_trials_again(both: Project) -> None:
    both.run("--lpb-trials=2", "scenarios").assert_outcomes(passed=2, failed=2)
    again = both.run("--lpb-trials=2", "--lf", "scenarios")
    again.assert_outcomes(failed=2)
    assert [row["scenario"] for row in both.rows()] == ["point/y", "point/y"]


def test_exitfirst_stops_after_the_first_failure(both: Project) -> None:
    result = both.run("-x", "--lpb-trials=3", "scenarios/point/y.yaml", "scenarios/point/x.yaml")
    result.assert_outcomes(failed=1)
    assert both.row()["outcome"] == "timeout"


def test_registered_tags_pass_strict_markers(both: Project) -> None:
    both.ini("markers =", "    bookshelf: a shelf")
    both.scenario("scenarios/point/z.yaml", UNSOLVED.replace("[planar]", "[bookshelf]"))
    assert len(collected(both, "--strict-markers", "scenarios")) == 12


def test_unknown_tags_are_errors_under_strict_markers(both: Project) -> None:
    both.scenario("scenarios/point/x.yaml", UNSOLVED.replace("[planar]", "[planar, narow]"))
    result = both.run("--strict-markers", "scenarios")
    assert result.ret == 2
    text = text_of(result)
    assert "scenarios/point/x.yaml:2: tags: 'narow' not found in `markers`" in text
    assert "register 'narow' in ini `markers`" in text
    assert "Traceback" not in text
    assert both.runs() == []


def test_unknown_tags_are_no_warnings_otherwise(both: Project) -> None:
    both.scenario("scenarios/point/x.yaml", UNSOLVED.replace("[planar]", "[bookshelf]"))
    result = both.run("-W", "error", "-m", "bookshelf", "--collect-only", "-q", "scenarios")
    assert node_ids(result) == ["scenarios/point/x.yaml::pd::seed0"]


@pytest.mark.parametrize("tag", ["skip", "xfail", "parametrize", "flaky", "usefixtures", "xdist_group"])
def test_tags_that_mean_something_to_pytest_are_refused(project: Project, tag: str) -> None:
    project.scenario(content=UNSOLVED.replace("[planar]", f"[{tag}]"))
    result = project.run("scenarios")
    assert result.ret == 2
    assert f"scenarios/point/x.yaml:2: tags[0]: found {tag!r}" in text_of(result)


def test_trials_of_all_files_stand_in_the_order_of_their_paths(project: Project) -> None:
    for name in ("b/x", "a/x", "c"):
        project.scenario(f"scenarios/{name}.yaml")
    listed = node_ids(project.run("--collect-only", "-q", "scenarios"))
    assert sorted(listed) == [f"scenarios/{name}.yaml::pd::seed0" for name in ("a/x", "b/x", "c")]
    assert listed == node_ids(project.run("--collect-only", "-q", "scenarios"))


def test_where_scenarios_are_looked_for_is_told(project: Project) -> None:
    """Not where there are some, and the user's own -k leaves all of them out."""
    (project.path / "empty").mkdir()
    assert "lpb: no scenario was found: name the files" in text_of(project.run("empty"))
    project.scenario()
    left_out = project.run("scenarios", "-k", "nothing_of_this_name")
    assert left_out.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    assert "no scenario was found" not in text_of(left_out)
    assert "1 deselected" in text_of(left_out)
