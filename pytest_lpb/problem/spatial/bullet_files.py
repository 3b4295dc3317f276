"""Bodies that pass through Bullet's own files, since PyBullet's functions change what they are given.

PyBullet lays the vertices of each convex hull it makes on a grid of 1/10216 of the hull's extents, and gives out no
triangles of some meshes. Bullet's files have both as they are: a file that PyBullet writes of a world with tetrahedra
is read back with other vertices in their place, which Bullet takes without laying them anywhere.

A file is a header and chunks: code, length, address, type and count, then the content (Bullet's `btSerializer.h`).
"""

from __future__ import annotations

import struct
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from pytest_lpb.errors import LpbError
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.client import Client, pybullet

KIND = b"BULLETd-v"  # of double precision, 64 bits, little-endian
HEADER_BYTES = len(KIND) + 3  # with the version
CHUNK = struct.Struct("<4siQii")  # code, bytes of content, address, type, count
LINK = struct.Struct("<Qi")  # in a hull: address and number of its vertices
VERTEX_BYTES = 32  # four doubles, the last one unused
TETRAHEDRON = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
MARGIN_M = float(np.float32(0.001))  # [m] of hulls from files, which keep it in single precision
SETTINGS = b"DWLD"  # of the world: not to be taken over


@dataclass(frozen=True)
class Chunk:
    """A part of a file."""

    code: bytes
    address: int
    kind: int  # index of the type of its elements
    count: int
    content: bytes

    @property
    def holds_vertices(self) -> bool:
        """Whether it is an array of vectors."""
        return self.code == b"ARAY" and len(self.content) == self.count * VERTEX_BYTES

    def packed(self) -> bytes:
        """As it stands in a file."""
        return CHUNK.pack(self.code, len(self.content), self.address, self.kind, self.count) + self.content


def chunks_of(file: bytes) -> Iterator[Chunk]:
    """All chunks of a file. Raises LpbError for one that another build of Bullet wrote."""
    if not file.startswith(KIND):
        raise LpbError(f"this PyBullet writes files of the kind {file[:HEADER_BYTES]!r}; {KIND!r} is required")
    at = HEADER_BYTES
    while at + CHUNK.size <= len(file):
        code, length, address, kind, count = CHUNK.unpack_from(file, at)
        at += CHUNK.size
        yield Chunk(code, address, kind, count, file[at : at + length])
        at += length


def saved_world(client: Client) -> bytes:
    """Bullet's file of all bodies in a client that are one rigid part."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.bullet"
        client.call("saveBullet", str(path))
        return path.read_bytes()


def vertices_of(file: bytes) -> FloatArray:
    """All vertices (n, 3) [m] in a file."""
    rows = [np.frombuffer(chunk.content).reshape(-1, 4)[:, :3] for chunk in chunks_of(file) if chunk.holds_vertices]
    return np.vstack(rows) if rows else np.zeros((0, 3))


def create_hulls(client: Client, pieces: Sequence[FloatArray]) -> int:
    """Create a body at the origin that is the union of convex hulls of vertices (n, 3) [m]; its PyBullet id.

    Bullet surrounds each hull with a margin of `MARGIN_M`. The body stands still, and collides with what it meets.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hulls.bullet"
        path.write_bytes(_with_vertices(_tetrahedra(len(pieces)), pieces))
        (body,) = client.call("loadBullet", str(path))
    return int(body)


def _with_vertices(file: bytes, pieces: Sequence[FloatArray]) -> bytes:
    """A file of tetrahedra, each with the vertices (n, 3) of a piece in place of its own."""
    chunks = [chunk for chunk in chunks_of(file) if chunk.code != SETTINGS]
    numbers = {chunk.address: number for number, chunk in enumerate(c for c in chunks if c.holds_vertices)}
    assert len(numbers) == len(pieces), f"{len(numbers)} tetrahedra for {len(pieces)} hulls"
    links = {LINK.pack(address, 4): LINK.pack(address, len(pieces[number])) for address, number in numbers.items()}
    parts = [file[:HEADER_BYTES]]
    for chunk in chunks:
        count, content = chunk.count, chunk.content
        if chunk.holds_vertices:
            rows = np.zeros((len(pieces[numbers[chunk.address]]), 4))
            rows[:, :3] = pieces[numbers[chunk.address]]
            count, content = len(rows), rows.tobytes()
        elif chunk.code == b"SHAP":
            for old, new in links.items():
                content = content.replace(old, new)
        parts.append(Chunk(chunk.code, chunk.address, chunk.kind, count, content).packed())
    return b"".join(parts)


@lru_cache(maxsize=16)
def _tetrahedra(count: int) -> bytes:
    """Bullet's file of one body of several tetrahedra."""
    lines = []
    for index in range(count):
        lines.append(f"o part{index}")
        # Each another size: Bullet writes equal shapes once.
        lines += [f"v {x} {y} {z}" for x, y, z in ((1.0 + index) * TETRAHEDRON).tolist()]
        lines += [f"f {4 * index + a} {4 * index + b} {4 * index + c}" for a, b, c in _FACES]
    client = Client()
    try:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "tetrahedra.obj"
            path.write_text("\n".join([*lines, ""]), encoding="utf-8")
            shape = client.call("createCollisionShape", pybullet.GEOM_MESH, fileName=str(path))
            client.call("createMultiBody", 0, shape, useMaximalCoordinates=1)
        return saved_world(client)
    finally:
        client.close()


_FACES = ((1, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4))
