"""Run folders: run.json, trials/, tables. One per run, below the reports folder; `latest` leads to the newest."""

from __future__ import annotations

import json
import secrets
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime
from json import dumps
from pathlib import Path
from typing import Any

from pytest_lpb.bounded import read_bounded
from pytest_lpb.documents.atomic import recording_error, remove, remove_unfinished, replace_file, unfinished, write_once
from pytest_lpb.errors import RecordingError
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.run.inputs import write_planner_files
from pytest_lpb.run.run_file import read_run_file

RUN_FILE = "run.json"
LATEST = "latest"
# Of a folder of runs that we have made ourselves; what a user keeps there in git is the user's business.
GITIGNORE = b"# Written by pytest-lpb when it made this folder: runs are results, not sources.\n*\n"
MAX_NAME_BYTES = 1000  # of a run folder's name in `latest`


def new_run_folder(reports: Path) -> Path:
    """Path of a new run folder, such as reports/20261122T024921Z-74be96; nothing is made yet."""
    return reports / f"{datetime.now(UTC):%Y%m%dT%H%M%SZ}-{secrets.token_hex(3)}"


def check_writable(reports: Path) -> None:
    """Check that run folders can be made in `reports`, without leaving anything. Raises RecordingError."""
    parent = reports
    while not parent.exists() and parent != parent.parent:
        parent = parent.parent
    try:
        if not parent.is_dir():
            raise NotADirectoryError(0, "it is not a folder")
        with tempfile.TemporaryDirectory(dir=parent, prefix=".lpb-"):
            pass
    except OSError as error:
        raise RecordingError(
            f"reports folder {reports}: cannot write to {parent}: {error.strerror}; "
            "choose another with --lpb-reports=DIR"
        ) from None


class RunFolder:
    """A run folder that exists."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @property
    def name(self) -> str:
        """The folder's name."""
        return self.path.name

    @classmethod
    def create(
        cls, path: Path, info: dict[str, Any], planners: Iterable[PlannerConfiguration] = (), *, latest: bool = True
    ) -> RunFolder:
        """Make a run folder, which appears at once, with run.json and its planners' files; then `latest`, unless not.

        Raises RecordingError, and nothing is left.
        """
        is_first = latest and not path.parent.exists()
        work = unfinished(path)
        try:
            try:
                (work / "trials").mkdir(parents=True)
                _write_info(work, info)
                write_planner_files(work, planners)
                work.rename(path)
                if is_first:
                    write_once(path.parent / ".gitignore", GITIGNORE)
            finally:
                shutil.rmtree(work, ignore_errors=True)
        except OSError as error:
            raise recording_error(f"cannot make {path}", error) from error
        try:
            if latest:
                _point_latest(path)
        except RecordingError:
            shutil.rmtree(path, ignore_errors=True)
            raise
        return cls(path)

    def add(self, planner: PlannerConfiguration, scenarios: Mapping[str, Any]) -> None:
        """Note a planner, and scenarios by key, of trials that are added. Raises RecordingError."""
        noted = self.info()
        before = dumps(noted)
        noted.setdefault("planners", {})[planner.name] = planner.to_dict()
        noted["scenarios"] = {**noted.get("scenarios", {}), **scenarios}
        if dumps(noted) != before:
            _write_info(self.path, noted)
            write_planner_files(self.path, [planner])

    def resume(self, info: dict[str, Any]) -> None:
        """Note in run.json that the run goes on: `started`, `command`, `workers` of `info`. `latest` leads here."""
        noted = self.info()
        noted.setdefault("resumed", []).append({key: info[key] for key in ("started", "command", "workers")})
        _write_info(self.path, noted)
        _point_latest(self.path)

    def tidy(self) -> None:
        """Remove what a run that was killed has left. None may be at work in the folder. Raises RecordingError."""
        remove_unfinished(self.path)
        for link in self.path.parent.glob(f".{LATEST}-{self.name}-*"):
            remove(link)

    @classmethod
    def open(cls, path: Path) -> RunFolder:
        """A run folder by its path, or by that of `latest`. Raises RecordingError when it is none."""
        resolved = path
        if path.name == LATEST and path.is_file():
            name = read_bounded(path, MAX_NAME_BYTES, RecordingError).decode("utf-8", errors="replace").strip()
            resolved = path.parent / name.replace("\0", "")
        if not (resolved / RUN_FILE).is_file():
            raise RecordingError(f"{path} is no run folder: it has no {RUN_FILE}{_runs_near(path)}")
        return cls(resolved.resolve())

    def info(self) -> dict[str, Any]:
        """What run.json says. Raises RecordingError when it cannot be read."""
        return read_run_file(self.path / RUN_FILE)

    def trial_files(self) -> Iterator[Path]:
        """All trial files, in the order of their paths."""
        yield from sorted(path for path in (self.path / "trials").rglob("seed*.parquet") if path.is_file())


def _write_info(run: Path, info: dict[str, Any]) -> None:
    text = json.dumps(info, indent=1, allow_nan=False)
    replace_file(run / RUN_FILE, f"{text}\n".encode())


def _point_latest(run: Path) -> None:
    """Swap `latest` atomically: a symbolic link, or a file with the folder's name where links are refused."""
    latest = run.parent / LATEST
    link = run.parent / f".{LATEST}-{run.name}-{secrets.token_hex(4)}"
    try:
        link.symlink_to(run.name, target_is_directory=True)
        link.replace(latest)
    except OSError:
        link.unlink(missing_ok=True)
        replace_file(latest, f"{run.name}\n".encode())


def _runs_near(path: Path) -> str:
    folder = path if path.is_dir() else path.parent
    runs = sorted(child.parent.name for child in folder.glob(f"[!.]*/{RUN_FILE}")) if folder.is_dir() else []
    return f"; run folders in {folder}: {', '.join(runs[-5:])}" if runs else ""
