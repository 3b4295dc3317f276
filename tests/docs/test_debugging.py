"""docs/debugging.md: its planner fails as the page says, and the debugger stops where it says."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.plugin.projects import FAST, UNSOLVED, Project, text_of

from .test_examples import blocks

PAGE = "docs/debugging.md"
STOPS = """
import dwa

class Stops(dwa.Dwa):
    name = "stops"
    def compute_action(self, observation):
        here = 7
        breakpoint()
        return [0.0, 0.0]
"""


@pytest.fixture
def failing(project: Project, monkeypatch: pytest.MonkeyPatch) -> Project:
    for name in ("CI", "BUILD_NUMBER"):  # where they are set, pytest shows every failure in full
        monkeypatch.delenv(name, raising=False)
    project.write("dwa.py", blocks(PAGE, "python")[0])
    project.write("planners/dwa.yaml", blocks(PAGE, "yaml")[0])
    project.scenario("scenarios/disc.yaml", UNSOLVED)
    return project


def test_the_debugger_stops_in_the_planner_and_quits(failing: Project) -> None:
    failing.write("conftest.py", STOPS)
    typed = b"p 'locals', scale, reach\nup\np observation['t']\nc\np 'here is', here\nq\n"
    result = failing.pytester.run(
        *(sys.executable, "-m", "pytest", "-p", "no:hypothesispytest", "--pdb", "--lpb-planners=dwa,stops,pd", FAST),
        stdin=typed,
    )
    text = text_of(result)
    assert result.ret == pytest.ExitCode.INTERRUPTED
    assert f"> {failing.path / 'dwa.py'}(14)best()\n-> return scale / self.gain" in text
    assert "('locals', array([6., 0.]), array([3., 0.]))" in text
    assert "array(0.15)" in text
    assert "('here is', 7)" in text
    assert "Exit: Quitting debugger" in text
    # Recorded is what raised; not what the debugger was left in, nor what was to come after it.
    (run,) = failing.runs()
    files = [path.relative_to(run / "trials").as_posix() for path in (run / "trials").rglob("*.*")]
    assert sorted(files) == ["disc/dwa/seed0.parquet", "disc/dwa/seed0.yaml"]
    assert "1 of 3 trials were run; run the others with: pytest --lpb-resume=reports/" in text


def test_equal_faults_are_one_and_local_variables_are_shown(failing: Project) -> None:
    result = failing.run("-l", "--lpb-report=none", "--lpb-trials=22", "scenarios", planners="dwa")
    text = text_of(result)
    result.assert_outcomes(failed=22)
    assert text.count("return scale / self.gain") == 1
    assert text.count("scale      = array([6., 0.])") == 1
    assert "21 other trials ended by the same fault (-vv shows each):\n  scenarios/disc.yaml::dwa::seed1\n" in text
    told = [line.strip() for line in (Path(__file__).parents[2] / PAGE).read_text("utf-8").splitlines()]
    assert [line for line in result.stdout.lines if line.strip() in told and "dwa" in line][-2:] == [
        "22 trials of dwa: planner_error: AttributeError: 'Dwa' object has no attribute 'gain' (dwa.py:14)",
        "  repeat the first: pytest --lpb-planners=dwa --lpb-seed=0 --lpb-trials=1 scenarios/disc.yaml::dwa::seed0",
    ]
    run = failing.runs()[-1]
    assert f"raw data: reports/{run.name}; tables and report: lpb-report reports/{run.name}" in text
    assert {path.name for path in run.iterdir()} == {"run.json", "planners", "trials"}
