"""Checks pictures that materials name: small files may hold pictures that take gigabytes."""

from __future__ import annotations

import warnings
from pathlib import Path

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.spatial.mesh_limits import MAX_TEXTURE_PIXELS


def check_texture(path: Path) -> None:
    """Check a picture's size, which its first bytes say. Raises ScenarioError for what is no picture."""
    from PIL import Image, UnidentifiedImageError  # late: only meshes with textures need it

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(path) as picture:
                width, height = picture.size
    except Image.DecompressionBombError:
        width, height = MAX_TEXTURE_PIXELS, 2
    except (UnidentifiedImageError, OSError, ValueError, SyntaxError) as error:
        raise ScenarioError(f"{path}: is no picture that can be read: {error}") from None
    if width * height > MAX_TEXTURE_PIXELS:
        raise ScenarioError(f"{path}: has {width} x {height} pixels; a texture may have {MAX_TEXTURE_PIXELS}")
