"""`-n`: the same trials, one row each, to the last bit what a serial run gives."""

from __future__ import annotations

import pytest

from pytest_lpb.plugin.resolving import _workers

from .projects import DRAWN, UNSOLVED, Project, read_run, text_of

Hashes = dict[tuple[str, str, str], str]
ARGUMENTS = ("--lpb-trials=2", "scenarios")
PLANNERS = "pd,potential_field"


@pytest.fixture
def both(project: Project) -> Project:
    project.scenario("scenarios/drawn.yaml", DRAWN)
    project.scenario("scenarios/far.yaml", UNSOLVED)
    return project


def serial(project: Project) -> Hashes:
    project.run(*ARGUMENTS, planners=PLANNERS).assert_outcomes(passed=4, failed=4)
    hashes = project.hashes()
    assert len(hashes) == 8
    return hashes


@pytest.mark.parametrize("mode", ["load", "loadscope", "loadfile", "loadgroup", "worksteal", "each", "no"])
def test_every_way_to_share_out_trials(both: Project, mode: str) -> None:
    expected = serial(both)
    result = both.run_workers("--dist", mode, *ARGUMENTS, planners=PLANNERS)
    times = 2 if mode == "each" else 1
    result.assert_outcomes(passed=4 * times, failed=4 * times)
    assert result.ret == 1
    rows = both.rows()
    assert len(rows) == 8
    assert [row["node_id"] for row in rows] == [row["node_id"] for row in both.rows(both.runs()[0])]
    assert both.hashes() == expected
    run = both.runs()[-1]
    assert read_run(run)["workers"] == 2
    assert "INTERNALERROR" not in text_of(result)


def test_order_and_company_change_nothing(both: Project) -> None:
    expected = serial(both)
    both.write("conftest.py", "def pytest_collection_modifyitems(items):\n    items.reverse()\n")
    result = both.run(*ARGUMENTS, "-v", planners=PLANNERS)
    lines = [line for line in result.stdout.lines if "::seed" in line and "%]" in line]
    assert lines[0].startswith("scenarios/far.yaml::potential_field::seed1")
    assert both.hashes() == expected
    for scenario, planner, seed in list(expected)[::3]:
        both.run(f"scenarios/{scenario}.yaml", f"--lpb-seed={seed}", "--lpb-trials=1", planners=planner)
        assert both.hashes() == {(scenario, planner, seed): expected[scenario, planner, seed]}


class _Config:
    def __init__(self, tx: list[str] | None) -> None:
        self.option = type("Option", (), {"tx": tx})


@pytest.mark.parametrize(
    ("tx", "workers"),
    [(None, 1), ([], 1), (["popen", "popen"], 2), (["3*popen"], 3), (["2*popen", "popen"], 3)],
)
def test_number_of_workers(tx: list[str] | None, workers: int) -> None:
    assert _workers(_Config(tx)) == workers  # type: ignore[arg-type]
