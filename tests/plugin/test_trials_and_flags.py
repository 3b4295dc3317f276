"""`--lpb-trials`, `--lpb-seed`, `--lpb-random-*`."""

from __future__ import annotations

import pytest

from .projects import SCENARIO, Project, node_ids, read_run, text_of

RANGES = SCENARIO + (
    "randomize:\n"
    "  start: {q: [[-0.01, 0.01], [-0.01, 0.01]]}\n"
    "  goal: [[-0.05, 0.05], [-0.05, 0.05]]\n"
    "  obstacles: {count: 2, shape: circle, position: [[2, 3], [2, 3]], radius: [0.1, 0.2]}\n"
)


def seeds(project: Project, *arguments: str) -> list[int]:
    lines = node_ids(project.run("--collect-only", "-q", *arguments, "scenarios"))
    return [int(line.rpartition("seed")[2]) for line in lines]


@pytest.mark.parametrize(
    ("scenario", "arguments", "expected"),
    [
        ("", (), [0]),
        ("trials: 3\n", (), [0, 1, 2]),
        ("trials: 2\nseed: 5\n", (), [5, 6]),
        ("trials: 2\nseed: 5\n", ("--lpb-trials=3",), [5, 6, 7]),
        ("trials: 2\nseed: 5\n", ("--lpb-seed=8",), [8, 9]),
        ("trials: 2\nseed: 5\n", ("--lpb-seed=0", "--lpb-trials=1"), [0]),
    ],
)
def test_seeds(project: Project, scenario: str, arguments: tuple[str, ...], expected: list[int]) -> None:
    project.scenario(content=SCENARIO + scenario)
    assert seeds(project, *arguments) == expected


def problems(project: Project, *arguments: str) -> list[str]:
    project.run("--lpb-trials=2", *arguments, "scenarios").assert_outcomes(passed=2)
    return [row["problem_hash"] for row in project.rows()]


def test_without_a_flag_ranges_are_not_drawn_from(project: Project) -> None:
    project.scenario(content=RANGES)
    first, second = problems(project)
    assert first == second


@pytest.mark.parametrize("part", ["start", "goal", "obstacles"])
def test_a_flag_draws_its_part(project: Project, part: str) -> None:
    project.scenario(content=RANGES)
    first, second = problems(project, f"--lpb-random-{part}")
    assert first != second
    assert read_run(project.runs()[-1])["random"] == [part]


def test_flags_for_parts_without_ranges_warn_once(project: Project) -> None:
    for name in ("x", "y"):
        project.scenario(f"scenarios/{name}.yaml")
    result = project.run("--lpb-trials=2", "--lpb-random-goal", "scenarios", planners="pd,potential_field")
    result.assert_outcomes(passed=8, warnings=1)
    expected = "--lpb-random-goal: no ranges in `randomize: goal`, it stays fixed in x, y"
    assert text_of(result).count(expected) == 1
    assert len({row["problem_hash"] for row in project.rows()}) == 1


def test_flags_for_parts_without_ranges_warn_once_with_workers_and_errors_for_warnings(project: Project) -> None:
    project.scenario()
    result = project.run_workers("--lpb-trials=2", "--lpb-random-goal", "-W", "error", "scenarios")
    result.assert_outcomes(passed=2, warnings=1)
    assert text_of(result).count("--lpb-random-goal: no ranges in `randomize: goal`") == 1


def test_a_part_that_cannot_be_drawn_is_one_trials_failure(project: Project) -> None:
    full = "  obstacles: {count: 1, shape: circle, position: [[0, 0], [0, 0]], radius: [1.0, 1.0]}\n"
    project.scenario(content=RANGES.split("  obstacles")[0] + full)
    result = project.run("--lpb-random-obstacles", "scenarios")
    result.assert_outcomes(failed=1)
    row = project.row()
    assert (row["outcome"], row["success"], row["steps"]) == ("environment_error", "false", "0")
    assert "1000 attempts" in text_of(result)
