"""Obstacles that an experiment takes from URDF files: one link of one shape, such as a mesh."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.scenario.import_lpb.fields import Fields
from pytest_lpb.scenario.import_lpb.motions import LostError

if TYPE_CHECKING:
    from pytest_lpb.problem.spatial.urdf import Geometry


def shape_of_urdf(fields: Fields, base: Path) -> dict[str, Any]:
    """The shape and size of an obstacle whose key `urdf` names a file beside the experiment.

    Args:
        fields: the obstacle.
        base: the folder that the scenario file will lie in.

    Raises:
        LostError: the file is not there, cannot be read, or is more than one shape at its origin.
    """
    from pytest_lpb.problem.spatial.urdf_reader import load_urdf  # late: most experiments have none

    path = fields.path.parent / str(fields.needed("urdf"))
    if not path.is_file():
        raise LostError(f"{fields.name}: its file {path} is not there")
    try:
        model = load_urdf(path)
    except ScenarioError as error:
        raise LostError(f"{fields.name}: {error}") from None
    shapes = [shape for link in model.links for shape in link.collisions]
    if len(shapes) != 1 or not np.allclose(shapes[0].origin, np.eye(4)):
        raise LostError(f"{fields.name}: {path} has {len(shapes)} shapes; converted is one, at the file's origin")
    return _sized(fields, shapes[0], fields.number("scaling", 1.0), base)


def _sized(fields: Fields, shape: Geometry, scaling: float, base: Path) -> dict[str, Any]:
    size = [scaling * length for length in shape.size]
    if shape.kind == "mesh":
        if max(size) - min(size) > 1e-9 * max(size) or shape.file is None:
            raise LostError(f"{fields.name}: its mesh is scaled by {shape.size}; converted is one factor for all axes")
        return {"shape": "mesh", "file": Path(os.path.relpath(shape.file, base)).as_posix(), "scale": size[0]}
    if shape.kind == "box":
        return {"shape": "box", "size": size}
    names = ("radius", "length")[: len(size)]
    return {"shape": shape.kind, **dict(zip(names, size, strict=True))}
