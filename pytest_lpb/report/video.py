"""A recorded trial as a video: its raw data drawn again, at the speed of the simulated time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import LpbError, RecordingError

DEFAULT_FPS = 30.0
PROGRESS_S = 3.0  # [s] between two lines of progress
MAX_AROUND = 200  # places of a path that must be in the picture
GIF_TICK_S = 0.01  # [s] GIF's unit of time
# libx264's constant quality; `faststart` lets a player begin before it has the whole file.
MP4_QUALITY = ["-crf", "20", "-preset", "fast", "-movflags", "+faststart"]

Image = NDArray[np.uint8]  # (height, width, 3)
Frames = Iterator[Image]


@dataclass(frozen=True)
class Format:
    """How a kind of video is written.

    Attributes:
        write: writes frames, at so many per second, to a path.
        most_fps: highest rate that players keep.
    """

    write: Callable[[Path, Frames, float], None]
    most_fps: float


def _write_mp4(path: Path, frames: Frames, fps: float) -> None:
    try:
        import imageio_ffmpeg
    except ImportError:
        raise LpbError(
            f"--video: {path.suffix} needs the package imageio-ffmpeg: pip install 'pytest-lpb[video]'; "
            "or write a .gif, which needs nothing more"
        ) from None
    first = next(frames)
    height, width, _ = first.shape
    writer = imageio_ffmpeg.write_frames(
        str(path), (width, height), fps=fps, codec="libx264", quality=None, output_params=MP4_QUALITY
    )
    try:
        writer.send(None)
        for frame in chain([first], frames):
            writer.send(np.ascontiguousarray(frame))
        writer.close()
    except OSError as error:
        raise RecordingError(f"cannot write {path.name}: ffmpeg says: {' '.join(str(error).split()[-40:])}") from error
    finally:
        writer.close()


def _write_gif(path: Path, frames: Frames, fps: float) -> None:
    from PIL import Image as Pillow

    indexed = (Pillow.fromarray(frame).quantize(method=Pillow.Quantize.FASTOCTREE, dither=0) for frame in frames)
    first = next(indexed)
    first.save(path, save_all=True, append_images=indexed, duration=_GifTimes(fps), loop=0)


class _GifTimes(list[int]):
    """Duration [ms] of each frame of a GIF, in its coarse unit, so that their sum is right at any frame."""

    def __init__(self, fps: float) -> None:
        super().__init__()
        self._fps = fps

    def __getitem__(self, index: Any) -> Any:
        begin, end = (round(number / self._fps / GIF_TICK_S) for number in (index, index + 1))
        return round(1000 * GIF_TICK_S) * (end - begin)
