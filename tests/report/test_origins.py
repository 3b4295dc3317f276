"""Which run and node id the command for a trial's video names, from wherever the report lies."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.origins import origins

NODE = "scenarios/a b/x.yaml::{}::seed3"


def of(run: ReportData, folder: Path | None, *trials: tuple[Path, str, str]) -> tuple[list[list[str]], list[object]]:
    """Origins of trials (run folder, planner there, planner here) for a report in a folder."""
    rows = [
        {
            "node_id": NODE.format(here),
            "scenario": "a b/x",
            "seed": 3,
            "file": str(home / "trials" / "a b/x" / there / "seed3.parquet"),
        }
        for home, there, here in trials
    ]
    return origins(replace(run, folder=folder), rows)  # type: ignore[return-value] # lists of text and numbers


@pytest.mark.parametrize(
    ("folder", "address"),
    [(None, "."), ("r 1#é", "."), ("r 1#é/selected", ".."), ("elsewhere/out", "../../r%201%23%C3%A9")],
)
def test_the_address_is_relative_to_the_report(
    run: ReportData, tmp_path: Path, folder: str | None, address: str
) -> None:
    home = tmp_path / "r 1#é"
    place = None if folder is None else tmp_path / folder
    assert of(run, place, (home, "pd", "pd")) == ([["r 1#é", address]], [[0, None]])


def test_merged_runs_have_their_own_names_for_planners(run: ReportData, tmp_path: Path) -> None:
    first, second = tmp_path / "one", tmp_path / "two"
    runs, trials = of(
        run, tmp_path / "merged", (first, "pd", "pd.aaa"), (second, "pd", "pd.bbb"), (first, "mpc", "mpc")
    )
    assert runs == [["one", "../one"], ["two", "../two"]]
    assert trials == [[0, NODE.format("pd")], [1, NODE.format("pd")], [0, None]]


def test_trials_without_files_are_the_reports_own(run: ReportData) -> None:
    rows = run.trials.to_dict("records")
    assert origins(run, rows) == ([[run.title, "."]], [[0, None]] * len(rows))
