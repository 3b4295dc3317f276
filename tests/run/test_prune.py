"""Old runs are removed, and nothing that is not one, that `latest` leads to, or that is running."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pytest_lpb.cli import main
from pytest_lpb.run.folder import RunFolder, new_run_folder
from pytest_lpb.run.lock import RunLock


@pytest.fixture
def reports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Five runs, `latest`, and what else may lie there."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "reports"
    for number in range(5):
        info = {"started": f"2026-11-2{number}T00:00:00+00:00", "planners": {}, "scenarios": {}}
        RunFolder.create(new_run_folder(folder), info).path.rename(folder / f"run{number}")
    (folder / "latest").unlink()
    (folder / "latest").symlink_to("run1")
    (folder / "again").symlink_to("run0")
    for name, content in (
        ("figures", None),
        ("other", "{}"),
        ("damaged", '{"planners": 3'),
        ("mine", '{"planners": {}}'),
    ):
        (folder / name).mkdir()
        if content is not None:
            (folder / name / "run.json").write_text(content)
    return folder


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_the_newest_stay(reports: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = names(reports)
    lock = RunLock()
    lock.take(reports / "run0")
    assert main(["--prune", "1", "--dry-run"]) == 0
    assert names(reports) == before
    assert main(["--prune=1"]) == 0
    assert names(reports) == before - {"run2", "run3"}
    told = capsys.readouterr().out.splitlines()
    assert told[-4:] == [
        "reports/run2 removed",
        "reports/run1 kept: latest leads to it",
        "reports/run0 kept: it is running",
        "2 runs removed from reports",
    ]
    lock.release()
    assert main(["reports", "--prune=0"]) == 0
    assert names(reports) == before - {"run0", "run2", "run3", "run4"}
    assert json.loads((reports / "latest" / "run.json").read_text())["started"].startswith("2026-11-21")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["reports/run0", "--prune=1"], "--prune: reports/run0 is a run; name the folder that its runs lie in"),
        (["latest", "--prune=1"], "--prune: latest is a run"),
        (["nowhere", "--prune=1"], "there is no folder nowhere"),
        (["--prune=-1"], "--prune: found -1; allowed are 0 and more"),
        (["reports", "reports", "--prune=1"], "--prune is about one folder of runs, found 2"),
        (["--prune=1", "--save-baseline=b.json"], "--prune only removes runs; leave --save-baseline out"),
        (["reports/run0", "--dry-run"], "--dry-run says what --prune=N would remove; add that"),
        ([], "RUN: missing; name a run folder"),
    ],
)
def test_wrong_arguments(reports: Path, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    before = names(reports)
    assert main(arguments) == 4
    assert message in capsys.readouterr().err
    assert names(reports) == before


def test_a_folder_that_we_make_is_none_of_git(tmp_path: Path) -> None:
    made, users = tmp_path / "reports", tmp_path / "results"
    users.mkdir()
    (users / ".gitignore").write_text("*.html\n")
    for folder in (made, tmp_path, users):
        RunFolder.create(new_run_folder(folder), {})
    assert (made / ".gitignore").read_text().splitlines()[-1] == "*"
    assert not (tmp_path / ".gitignore").exists()
    assert (users / ".gitignore").read_text() == "*.html\n"
