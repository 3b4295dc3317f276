"""A recorded trial as a video: its raw data drawn again, at the speed of the simulated time."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.environment.picture import picture_for
from pytest_lpb.errors import LpbError, RecordingError
from pytest_lpb.names import listed
from pytest_lpb.report.canvas import thinned
from pytest_lpb.report.scene_marks import primary_link
from pytest_lpb.trajectory import Trajectory

DEFAULT_FPS = 30.0
PROGRESS_S = 3.0  # [s] between two lines of progress
MAX_AROUND = 200  # places of a path that the picture must hold
GIF_TICK_S = 0.01  # [s] GIF's unit of time
# H.264 as all players know it, of constant quality; with `faststart` they begin before they have the whole file.
MP4_OPTIONS = ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", "-preset", "fast", "-movflags", "+faststart"]

Image = NDArray[np.uint8]  # (height, width, 3)


@dataclass(frozen=True)
class Footage:
    """Frames to write, in order."""

    frames: Iterator[Image]
    count: int
    fps: float


@dataclass(frozen=True)
class Format:
    """How a kind of video is written.

    Attributes:
        write: writes footage to a path.
        most_fps: highest rate that players keep.
    """

    write: Callable[[Path, Footage], None]
    most_fps: float


def _write_mp4(path: Path, footage: Footage) -> None:
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError:
        raise LpbError(
            "--video: .mp4 needs the package imageio-ffmpeg: pip install 'pytest-lpb[video]'; "
            "or write a .gif, which needs nothing more"
        ) from None
    first = next(footage.frames)
    height, width, _ = first.shape
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{footage.fps:g}", "-i", "-"]
    command = [get_ffmpeg_exe(), "-loglevel", "error", *source, *MP4_OPTIONS, str(path)]
    with tempfile.TemporaryFile() as complaints:
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=complaints) as ffmpeg:
            assert ffmpeg.stdin is not None
            # When ffmpeg has ended early, its words say more than the broken pipe.
            with contextlib.suppress(BrokenPipeError), ffmpeg.stdin as pipe:
                for frame in chain([first], footage.frames):
                    pipe.write(frame.tobytes())
        if ffmpeg.returncode:
            complaints.seek(0)
            said = " ".join(complaints.read().decode(errors="replace").split())
            raise RecordingError(f"--video: ffmpeg failed: {said or f'exit status {ffmpeg.returncode}'}")


def _write_gif(path: Path, footage: Footage) -> None:
    from PIL import Image as Pillow

    # Times between whole ticks, so that the video is right at every frame and not only nearly.
    ticks = np.round(np.arange(footage.count + 1) / footage.fps / GIF_TICK_S)
    durations_ms = np.diff(ticks * GIF_TICK_S * 1000.0).round().astype(int).tolist()
    images = (Pillow.fromarray(frame).quantize(method=Pillow.Quantize.FASTOCTREE) for frame in footage.frames)
    next(images).save(path, save_all=True, append_images=images, duration=durations_ms, loop=0)


# A new kind of video is one entry here.
FORMATS: dict[str, Format] = {
    ".mp4": Format(_write_mp4, 1000.0),
    ".gif": Format(_write_gif, 0.5 / GIF_TICK_S),  # players slow down what is faster
}


def format_of(path: Path, fps: float) -> Format:
    """The format that a file's suffix names. Raises LpbError for an unknown one, and for a rate it cannot have."""
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise LpbError(f"--video: found {path.name!r}; a video's name ends with {listed(FORMATS)}")
    most = FORMATS[suffix].most_fps
    if not 0.0 < fps <= most:
        raise LpbError(f"--fps: found {fps:g}; allowed for {suffix} are rates above 0 and up to {most:g} per second")
    return FORMATS[suffix]


def write_video(trajectory: Trajectory, path: Path, fps: float = DEFAULT_FPS) -> Path:
    """Draw a trial's raw data into a video, one second of it for each simulated second.

    Args:
        trajectory: one trial; it ends where its numbers do.
        path: its suffix says what is written; the file appears when it is whole.
        fps: frames per second.

    Raises LpbError for what cannot be written or drawn.
    """
    kind = format_of(path, fps)
    rows = rows_of_frames(trajectory, fps)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".lpb-") as folder:
            unfinished = Path(folder) / path.name
            kind.write(unfinished, Footage(_told(_drawn(trajectory, rows), len(rows)), len(rows), fps))
            unfinished.replace(path)
    except OSError as error:
        raise RecordingError(f"cannot write {path}: {error.strerror or error}") from error
    return path


def rows_of_frames(trajectory: Trajectory, fps: float) -> list[int]:
    """The row that each frame shows: the nearest one in time; the last frame shows the last row.

    Raises LpbError for a trial without rows.
    """
    endless = np.flatnonzero(~np.isfinite(trajectory.q).all(axis=1))
    last = int(endless[0] if len(endless) else len(trajectory)) - 1
    if last < 0:
        raise LpbError(f"--video: {trajectory.metadata['node_id']} has no recorded motion ({trajectory.outcome})")
    dt = trajectory.problem.dt
    count = max(round(last * dt * fps), 1)
    rows = np.round(np.arange(count) / (fps * dt)).astype(int).clip(max=last)
    rows[-1] = last
    return [int(row) for row in rows]


def _drawn(trajectory: Trajectory, rows: list[int]) -> Iterator[Image]:
    """A picture for each of these rows."""
    problem = trajectory.problem
    path = trajectory.link(primary_link(trajectory))[: rows[-1] + 1, : problem.dimension]
    picture = picture_for(problem.dimension, show=False, around=thinned(path, MAX_AROUND))
    shown, frame = -1, None
    try:
        for row in rows:
            if row != shown:
                shown, frame = row, picture.draw(problem, row, trajectory.q[row].tolist())
            assert frame is not None  # without a window there is a picture
            yield frame
    finally:
        picture.close()


def _told(frames: Iterator[Image], count: int) -> Iterator[Image]:
    """The same frames; every few seconds a line says how far it is."""
    told = perf_counter()
    for number, frame in enumerate(frames, start=1):
        yield frame
        if perf_counter() - told > PROGRESS_S:
            told = perf_counter()
            print(f"lpb-report: video: {number} of {count} frames", file=sys.stderr, flush=True)
