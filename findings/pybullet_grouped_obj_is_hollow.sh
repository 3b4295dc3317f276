#!/usr/bin/env bash
# PyBullet 3.2.7, seen on 2026-12-01 with Python 3.11:
# an .obj whose sides are groups (`g front`, `g top`, .., as modelling tools name the faces of one solid) is hollow as a
# collision shape: each group is a convex hull of its own, so a cube becomes six thin walls. Without the `g` lines the
# same vertices and faces are one solid hull.
# Expected: names of groups are labels; the solid is the same with and without them.
# Output seen, cube of +-1 m, a ball of radius 0.2 m at its centre (true distance -1.2):
#   without groups: [-1.201]
#   a group per side: [0.799, 0.799, 0.799, 0.799, 0.799, 0.799]
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet pybullet==3.2.7 numpy==2.2.6
"$work/venv/bin/python" - "$work" <<'PYTHON'
import pathlib
import sys

import pybullet

CORNERS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
SIDES = {
    "back": (1, 2, 4, 3), "front": (5, 7, 8, 6), "left": (1, 5, 6, 2),
    "right": (3, 4, 8, 7), "bottom": (1, 3, 7, 5), "top": (2, 6, 8, 4),
}


def cube(grouped):
    lines = [f"v {x} {y} {z}" for x, y, z in CORNERS]
    for name, (a, b, c, d) in SIDES.items():
        lines += ([f"g {name}"] if grouped else []) + [f"f {a} {b} {c}", f"f {a} {c} {d}"]
    return "\n".join(lines) + "\n"


pybullet.connect(pybullet.DIRECT)
seen = {}
for grouped, label in ((False, "without groups"), (True, "a group per side")):
    file = pathlib.Path(sys.argv[1]) / f"cube_{grouped}.obj"
    file.write_text(cube(grouped))
    solid = pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_MESH, fileName=str(file)))
    ball = pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.2))
    seen[grouped] = sorted(point[8] for point in pybullet.getClosestPoints(solid, ball, 10.0))
    print(f"{label}: {[round(distance, 3) for distance in seen[grouped]]}")
    pybullet.removeBody(solid)
    pybullet.removeBody(ball)
assert len(seen[False]) == 1 and abs(seen[False][0] + 1.201) < 2e-3, "the cube without groups is no solid now"
assert len(seen[True]) == 6 and all(abs(d - 0.799) < 2e-3 for d in seen[True]), "the cube with groups is another now"
PYTHON
