"""Videos of trials, decoded again."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from pytest_lpb.errors import LpbError, RecordingError
from pytest_lpb.report.video import FORMATS, rows_of_frames, write_video
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.spatial.entries import point_entry, problem_of
from tests.report.runs import make_problem, make_trajectory
from tests.trial.specifications import configuration

Frames = NDArray[np.uint8]  # (N, height, width, 3)


@pytest.fixture(scope="module")
def planar() -> Trajectory:
    """A point on its way, 61 rows of 0.05 s."""
    return make_trajectory(make_problem("point/two_obstacles", 0), "scenarios/x.yaml::pd::seed0", 2.2, rows=61)


@pytest.fixture(scope="module")
def spatial(tmp_path_factory: pytest.TempPathFactory) -> Trajectory:
    """A ball in space that moves towards a goal, 101 rows of 0.01 s."""
    goal = {"name": "reach", "type": "position", "link": "body", "target": [3.0, 0.0, 1.0], "tolerance": 0.1}
    box = {"name": "box", "shape": "box", "size": [0.4, 0.4, 0.4], "trajectory": ["1.5", "1.2 + 0.5*t", "0.2"]}
    problem = problem_of(tmp_path_factory.mktemp("scenario"), point_entry(0.3, [box], goal=[goal]))
    planner = configuration("pd", {"p": 6.0, "k": 2.0})
    trajectory = run_trial(TrialSpecification(problem=problem.to_dict(), planner=planner, node_id="x::pd::seed0"))
    assert len(trajectory) == 101
    return trajectory


def changed(trajectory: Trajectory, **columns: NDArray[Any]) -> Trajectory:
    copied = {name: values.copy() for name, values in trajectory.columns.items()}
    return Trajectory(copied | columns, trajectory.metadata, trajectory.problem)


def decoded(path: Path) -> tuple[Frames, str]:
    """All frames of a video, and what ffmpeg says of it."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(path), "-fps_mode", "passthrough", "-f", "rawvideo"]
    result = subprocess.run([*command, "-pix_fmt", "rgb24", "-"], capture_output=True, check=True)
    about = result.stderr.decode()
    (width, height), *_ = re.findall(r", (\d+)x(\d+)", about)
    return np.frombuffer(result.stdout, np.uint8).reshape(-1, int(height), int(width), 3), about


@pytest.mark.parametrize(("kind", "fps"), [("planar", 10.0), ("spatial", 30.0), ("spatial", 24.0)])
def test_mp4_has_a_frame_for_each_moment(request: pytest.FixtureRequest, tmp_path: Path, kind: str, fps: float) -> None:
    trajectory: Trajectory = request.getfixturevalue(kind)
    path = write_video(trajectory, tmp_path / "new folder" / "out.mp4", fps)
    frames, about = decoded(path)
    duration = float(trajectory.t[-1])
    assert len(frames) == round(duration * fps)
    assert f" {fps:g} fps" in about
    (seconds,) = re.findall(r"Duration: 00:00:([\d.]+)", about)
    assert float(seconds) == pytest.approx(duration, abs=0.6 / fps)
    assert "Video: h264" in about
    assert "yuv420p" in about
    difference = np.abs(frames[0].astype(int) - frames[-1]).max(axis=2)
    assert (difference > 60).sum() > 200
    assert [file.name for file in path.parent.iterdir()] == ["out.mp4"]


def test_the_robot_moves_as_recorded(spatial: Trajectory, tmp_path: Path) -> None:
    frames, _ = decoded(write_video(spatial, tmp_path / "out.mp4", 20.0))
    blue = (frames[..., 2] > frames[..., 1].astype(int) + 30) & (frames[..., 1] > frames[..., 0].astype(int) + 30)
    columns = np.array([np.nonzero(mask)[1].mean() for mask in blue])
    moved = spatial.q[rows_of_frames(spatial, 20.0), 0]
    # Along a straight way, seen from the side, places in the picture follow those in the world.
    assert abs(np.corrcoef(columns, moved)[0, 1]) > 0.99


@pytest.mark.parametrize(("kind", "fps"), [("planar", 7.0), ("spatial", 30.0)])
def test_gif_lasts_as_long_as_the_trial(request: pytest.FixtureRequest, tmp_path: Path, kind: str, fps: float) -> None:
    trajectory: Trajectory = request.getfixturevalue(kind)
    with Image.open(write_video(trajectory, tmp_path / "out.GIF", fps)) as gif:
        durations_ms = []
        for number in range(gif.n_frames):  # type: ignore[attr-defined] # of images with frames
            gif.seek(number)
            durations_ms.append(gif.info["duration"])
        assert gif.info["loop"] == 0
        assert len(set(durations_ms)) > 1 or fps == 20.0  # whole hundredths of a second, evened out
    frames = len(rows_of_frames(trajectory, fps))
    assert sum(durations_ms) == pytest.approx(1000 * frames / fps, abs=5.1)


def test_rows_are_the_nearest_in_time(planar: Trajectory) -> None:
    dt = planar.problem.dt
    for fps in (4.0, 20.0, 30.0, 60.0):
        rows = np.array(rows_of_frames(planar, fps))
        times = np.arange(len(rows)) / fps
        assert (np.abs(rows * dt - times)[:-1] <= 0.5 * dt + 1e-9).all()
        assert rows[-1] == len(planar) - 1


def test_a_trial_of_one_row_is_one_frame(planar: Trajectory, tmp_path: Path) -> None:
    one = Trajectory(
        {name: values[:1].copy() for name, values in planar.columns.items()}, planar.metadata, planar.problem
    )
    assert rows_of_frames(one, 30.0) == [0]
    assert len(decoded(write_video(one, tmp_path / "one.mp4"))[0]) == 1


def test_a_trial_that_diverges_ends_where_its_numbers_do(planar: Trajectory) -> None:
    q = np.where(np.arange(len(planar)) < 30, planar.q[:, 0], np.nan)
    rows = rows_of_frames(changed(planar, q0=q), 20.0)
    assert rows[-1] == 29
    assert max(rows) == 29
    with pytest.raises(LpbError, match=r"--video: scenarios/x\.yaml::pd::seed0 has no recorded motion"):
        rows_of_frames(changed(planar, q0=np.full(len(planar), np.nan)), 20.0)


def test_a_path_that_runs_away_does_not_shrink_the_picture(spatial: Trajectory, tmp_path: Path) -> None:
    far = {f"link_body_{letter}": spatial.columns[f"link_body_{letter}"] * 1e5 for letter in "xyz"}
    frames, _ = decoded(write_video(changed(spatial, **far), tmp_path / "out.mp4", 3.0))
    blue = (frames[0][..., 2] > frames[0][..., 1].astype(int) + 30) & (frames[0][..., 1] > frames[0][..., 0])
    assert blue.sum() > 100


@pytest.mark.parametrize(
    ("name", "fps", "message"),
    [
        ("out.avi", 30.0, r"--video: found 'out\.avi'; a video's name ends with \.gif, \.mp4"),
        ("out", 30.0, r"found 'out'"),
        ("out.mp4", 0.0, r"--fps: found 0; allowed for \.mp4 are rates above 0 and up to 1000 per second"),
        ("out.gif", 51.0, r"--fps: found 51; allowed for \.gif are rates above 0 and up to 50 per second"),
        ("out.mp4", float("nan"), "--fps: found nan"),
    ],
)
def test_what_cannot_be_written(planar: Trajectory, tmp_path: Path, name: str, fps: float, message: str) -> None:
    with pytest.raises(LpbError, match=message):
        write_video(planar, tmp_path / name, fps)
    assert not list(tmp_path.iterdir())


def test_without_imageio_ffmpeg(planar: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(LpbError, match=r"pip install 'pytest-lpb\[video\]'; or write a \.gif"):
        write_video(planar, tmp_path / "out.mp4")
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written(planar: Trajectory) -> None:
    with pytest.raises(RecordingError, match=r"cannot write /dev/null/x/out.mp4"):
        write_video(planar, Path("/dev/null/x/out.mp4"))


def test_when_ffmpeg_fails_its_words_are_told(
    planar: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_lpb.report.video.MP4_OPTIONS", ["-no_such_option"])
    with pytest.raises(RecordingError, match=r"--video: ffmpeg failed: .*no_such_option"):
        write_video(planar, tmp_path / "out.mp4", 2.0)
    assert not list(tmp_path.iterdir())


def test_progress_is_told(
    planar: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("pytest_lpb.report.video.PROGRESS_S", 0.0)
    write_video(planar, tmp_path / "out.gif", 2.0)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "lpb-report: video: 1 of 6 frames"
    assert len(lines) == 6


def test_each_format_has_a_name_of_its_own() -> None:
    assert all(suffix == suffix.lower() and suffix.startswith(".") for suffix in FORMATS)
