"""PyBullet, imported without its greeting, and private clients of it."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

STDERR = 2


@contextmanager
def _without_stderr() -> Iterator[None]:
    """PyBullet writes its build time from C when it is imported; that is no news to anybody."""
    sys.stderr.flush()
    kept, nowhere = os.dup(STDERR), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, STDERR)
    try:
        yield
    finally:
        os.dup2(kept, STDERR)
        os.close(kept)
        os.close(nowhere)


with _without_stderr():
    import pybullet

__all__ = ["Client", "pybullet"]


class Client:
    """A physics world of its own without a window; nothing in it is shared with other clients.

    Attributes: id, what PyBullet's functions take as `physicsClientId`.
    """

    def __init__(self) -> None:
        self.id: int = pybullet.connect(pybullet.DIRECT)
        self.set_up()

    def set_up(self) -> None:
        """Settings that every client has, whatever is loaded into it."""
        # The cache of files belongs to the process and knows names only: an edited mesh would stay the old one.
        pybullet.setPhysicsEngineParameter(
            deterministicOverlappingPairs=1, enableFileCaching=0, physicsClientId=self.id
        )

    def call(self, name: str, *arguments: Any, **keywords: Any) -> Any:
        """Call one of PyBullet's functions in this world."""
        return getattr(pybullet, name)(*arguments, physicsClientId=self.id, **keywords)

    def close(self) -> None:
        """Free the world and all that was loaded into it (about 28 MB). Again is no harm."""
        if self.id >= 0:
            pybullet.disconnect(physicsClientId=self.id)
            self.id = -1
