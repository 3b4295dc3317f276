"""The problems of an old run."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_lpb.errors import RecordingError
from pytest_lpb.study.recorded import recorded_families


def run_with(folder: Path, *files: str) -> Path:
    for name in files:
        path = folder / "trials" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("version: 1\n")
    return folder


def test_problems_by_scenario_and_seed(tmp_path: Path) -> None:
    names = ("a/b/pd/seed10.yaml", "a/b/pd/seed2.yaml", "a/b/mpc/seed2.yaml", "c/pd/seed0.yaml")
    families = recorded_families(run_with(tmp_path, *names))
    assert [(family.key, list(family.files)) for family in families] == [("a/b", [2, 10]), ("c", [0])]


@pytest.mark.parametrize(
    "name", ["seed3.yaml", "pd/seed3.yaml", "c/pd/seed.yaml", "c/pd/seed\u00b2.yaml", "c/pd/seed-1.yaml"]
)
def test_files_that_are_no_trials_are_passed_over(tmp_path: Path, name: str) -> None:
    assert [family.key for family in recorded_families(run_with(tmp_path / "some", "a/pd/seed0.yaml", name))] == ["a"]
    with pytest.raises(RecordingError, match="has no problem files"):
        recorded_families(run_with(tmp_path / "none", name))
