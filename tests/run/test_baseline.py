"""Baseline files and other baselines."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_lpb.errors import ConfigurationError, LpbError, RecordingError
from pytest_lpb.kpis.registry import default_registry, load_builtin
from pytest_lpb.run.baseline import open_baseline
from pytest_lpb.run.baseline_file import baseline_frame, read_baseline, rounded, save_baseline, saved_kpis
from pytest_lpb.run.evaluation import Evaluation, Selection, evaluate
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.gate import INCONCLUSIVE, Gate
from pytest_lpb.run.margins import parse_margins

from ..plugin.projects import read_run


@pytest.fixture(scope="module")
def evaluation(finished_run: Path) -> Evaluation:
    load_builtin()
    return evaluate(RunFolder.open(finished_run))


@pytest.fixture
def saved(evaluation: Evaluation, tmp_path: Path) -> Path:
    return save_baseline(evaluation, tmp_path / "new folder/baseline.json", saved_kpis(evaluation))


def content_of(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return content


def test_a_file_says_what_was_measured_and_where(saved: Path, finished_run: Path) -> None:
    content, run = content_of(saved), read_run(finished_run)
    assert (content["kind"], content["schema_version"]) == ("pytest-lpb baseline", 1)
    for key in ("machine", "packages", "git"):
        assert content[key] == run[key]
    assert list(content["planners"]) == ["pd", "potential_field"]
    planner = content["planners"]["pd"]
    assert planner["parameters_hash"] == run["planners"]["pd"]["parameters_hash"]
    assert [line[:2] for line in planner["trials"]] == [["drawn", 0], ["drawn", 1], ["unsolved", 0], ["unsolved", 1]]


def test_values_are_those_of_the_run_to_six_digits(saved: Path, evaluation: Evaluation) -> None:
    frame = baseline_frame(read_baseline(saved), "pd")
    own = evaluation.trials[evaluation.trials["planner"] == "pd"].reset_index(drop=True)
    for name in content_of(saved)["columns"][5:]:
        np.testing.assert_allclose(frame[name].astype(float), own[name].astype(float), rtol=5e-6)
    assert frame["success"].tolist() == own["success"].tolist()
    assert frame["problem_hash"].tolist() == [text[:16] for text in own["problem_hash"]]
    assert frame["duration_s"].tolist() == own["duration_s"].tolist()


def test_by_default_only_what_can_be_judged_anywhere_is_saved(saved: Path, evaluation: Evaluation) -> None:
    columns = content_of(saved)["columns"]
    assert {"time_to_goal_s", "path_length_m"} <= set(columns)
    kpis = {kpi.name: kpi for kpi in evaluation.kpis}
    assert not [name for name in columns[5:] if kpis[name].timing or kpis[name].direction == "none"]
    assert "final_goal_error_rad" not in columns  # nothing turns here: it has no values
    assert "timing_contended" not in columns


def test_named_kpis_are_saved(evaluation: Evaluation, tmp_path: Path) -> None:
    path = save_baseline(evaluation, tmp_path / "b.json", saved_kpis(evaluation, ["solver_time_p95_ms"]))
    assert content_of(path)["columns"][5:] == ["timing_contended", "solver_time_p95_ms"]


def test_a_trial_is_a_line_and_the_same_run_the_same_bytes(saved: Path, evaluation: Evaluation, tmp_path: Path) -> None:
    text = saved.read_text("utf-8")
    lines = [line for line in text.splitlines() if line.lstrip().startswith('["')]
    assert len(lines) == 8
    assert all(isinstance(json.loads(line.rstrip(",")), list) for line in lines)
    shuffled = Evaluation(
        evaluation.run, evaluation.trials.sample(frac=1, random_state=1), evaluation.kpis, evaluation.warnings
    )
    again = save_baseline(shuffled, tmp_path / "again.json", saved_kpis(evaluation))
    assert again.read_text("utf-8") == text
    assert len(text) < 8 * 400 + 2500


def test_rounding_is_its_own_fixed_point() -> None:
    rng = np.random.default_rng(0)
    for value in (rng.lognormal(0, 20, 200) * rng.choice([-1, 1], 200)).tolist():
        once = rounded(value)
        assert once is not None
        assert rounded(once) == once
        assert once == pytest.approx(value, rel=5e-6)
    assert rounded(float("nan")) is None


def test_a_run_without_trials_is_no_baseline(evaluation: Evaluation, tmp_path: Path) -> None:
    empty = Evaluation(evaluation.run, evaluation.trials[:0], evaluation.kpis, [])
    with pytest.raises(ConfigurationError, match="no trials to save"):
        save_baseline(empty, tmp_path / "b.json", [])


def broken(content: dict[str, Any], case: str) -> object:
    if case == "kind":
        return {**content, "kind": "else"}
    if case == "version":
        return {**content, "schema_version": 2}
    if case == "columns":
        return {**content, "columns": content["columns"][1:]}
    if case == "cells":
        content["planners"]["pd"]["trials"][0].append(1.0)
    if case == "twice":
        content["planners"]["pd"]["trials"] *= 2
    if case == "text":
        content["planners"]["pd"]["trials"][1][-1] = "much"
    return [] if case == "list" else {**content, "planners": 3} if case == "planners" else content


@pytest.mark.parametrize(
    ("case", "message"),
    [
        ("kind", "is no baseline: it has no 'pytest-lpb baseline' as its `kind`"),
        ("list", "is no baseline"),
        ("version", "schema_version is 2; this version reads 1"),
        ("columns", "is damaged: columns lack scenario"),
        ("cells", "is damaged: trial 0 of pd has"),
        ("twice", "is damaged: pd has drawn seed0 twice"),
        ("text", "is damaged: pd, drawn seed1: a value is no number"),
        ("planners", "is damaged"),
    ],
)
def test_files_that_are_refused(saved: Path, case: str, message: str) -> None:
    saved.write_text(json.dumps(broken(content_of(saved), case)), "utf-8")
    with pytest.raises(RecordingError) as caught:
        open_baseline(str(saved), Path())
    assert message in str(caught.value)
    assert str(saved) in str(caught.value)


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("seed", None, "pd, drawn seedNone: seed is None; allowed is a whole number"),
        ("seed", 0.5, "pd, drawn seed0.5: seed is 0.5; allowed is a whole number"),
        ("scenario", 5, "pd, 5 seed0: scenario is 5; allowed is text"),
        ("problem_hash", None, "pd, drawn seed0: problem_hash is None; allowed is text"),
        ("success", 1, "pd, drawn seed0: success is 1; allowed is true or false"),
        ("duration_s", float("inf"), "pd, drawn seed0: a value is no number"),
    ],
)
def test_cells_that_make_no_trial(saved: Path, column: str, value: object, message: str) -> None:
    content = content_of(saved)
    content["planners"]["pd"]["trials"][0][content["columns"].index(column)] = value
    saved.write_text(json.dumps(content), "utf-8")
    with pytest.raises(RecordingError, match=f"is damaged: {re.escape(message)}"):
        open_baseline(str(saved), Path())


def test_a_machine_that_is_none(saved: Path) -> None:
    saved.write_text(json.dumps({**content_of(saved), "machine": "fast"}), "utf-8")
    with pytest.raises(RecordingError, match="is damaged: machine is 'fast'"):
        open_baseline(str(saved), Path())


def test_no_json_and_no_file(tmp_path: Path) -> None:
    (tmp_path / "b.json").write_text("{", "utf-8")
    with pytest.raises(RecordingError, match="it is no JSON"):
        open_baseline("b.json", tmp_path)
    with pytest.raises(ConfigurationError, match=r"allowed are a baseline file \(written by lpb-report RUN --save-bas"):
        open_baseline("c.json", tmp_path)
    with pytest.raises(LpbError, match="is no run folder"):
        open_baseline(".", tmp_path)


def test_file_run_and_planner_give_the_same_verdicts(
    saved: Path, evaluation: Evaluation, finished_run: Path, tmp_path: Path
) -> None:
    shutil.copytree(finished_run, tmp_path / "run")
    margins = parse_margins(["success:5%", "time_to_goal_s:5%", "path_length_m:5%"], default_registry, "--x")
    machine = evaluation.run.info()["machine"]
    results = []
    for reference in (str(saved), "run"):
        gate = Gate(open_baseline(reference, tmp_path), margins)
        result = gate.judge(evaluation.trials, machine)
        assert (result.baseline, result.closed) == (reference, False)
        results.append([(v.planner, v.margin.name, v.problems, v.old, v.new, v.loss) for v in result.verdicts])
        assert all(v.verdict == INCONCLUSIVE and v.loss == 0 for v in result.verdicts if v.problems)
    assert results[0] == results[1]
    assert len(results[0]) == 6

    both = Gate(open_baseline("planner:pd", tmp_path), margins).judge(evaluation.trials, machine)
    assert [(v.planner, v.baseline) for v in both.verdicts] == [("potential_field", "pd")] * 3
    assert both.unknown == []


def test_what_a_baseline_knows_is_checked(saved: Path, finished_run: Path, tmp_path: Path) -> None:
    baseline = open_baseline(str(saved), tmp_path)
    assert baseline.counterparts(["mpc", "pd"]) == {"pd": "pd"}
    for reference in (str(saved), str(finished_run)):
        with pytest.raises(ConfigurationError, match=r"has no planner of this run: it has pd, potential_field, the r"):
            open_baseline(reference, tmp_path).counterparts(["mpc"])
    planner = open_baseline("planner:pd", tmp_path)
    with pytest.raises(ConfigurationError, match="no planner 'pd' in this run; did you mean 'pds'"):
        planner.counterparts(["pds"])
    with pytest.raises(ConfigurationError, match="pd is the only planner"):
        planner.counterparts(["pd"])
    assert planner.counterparts(["a", "pd", "b"]) == {"a": "pd", "b": "pd"}


def test_some_planners_alone(evaluation: Evaluation, tmp_path: Path) -> None:
    some = evaluation.selected(Selection(planners=["pd"]))
    path = save_baseline(some, tmp_path / "b.json", saved_kpis(some))
    assert list(content_of(path)["planners"]) == ["pd"]
