#!/usr/bin/env bash
# mpscenes 0.4.6 (scenes of localPlannerBench and urdfenvs), seen on 2026-12-01 with Python 3.11:
# the distance of a point to an upright cylinder is right above its middle and wrong below: a point one metre below the
# bottom is said to be `radius` deep inside.
# Expected: the same distance above and below a cylinder that is symmetric about its position.
# Output seen, for radius 0.5 and height 2 at the origin (true distances in brackets):
#   z = 2.0: 1.000 (1.000)
#   z = 1.2: 0.200 (0.200)
#   z = -1.2: -0.500 (0.200)
#   z = -2.0: -0.500 (1.000)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet mpscenes==0.4.6 geomdl==5.4.0 'numpy<2'
"$work/venv/bin/python" - <<'PYTHON'
import numpy as np
from mpscenes.obstacles.cylinder_obstacle import CylinderObstacle

geometry = {"position": [0.0, 0.0, 0.0], "radius": 0.5, "height": 2.0}
cylinder = CylinderObstacle(name="post", content_dict={"type": "cylinderObstacle", "geometry": geometry})
seen = []
for z in (2.0, 1.2, -1.2, -2.0):
    seen.append(float(cylinder.distance(np.array([0.0, 0.0, z]))))
    print(f"z = {z}: {seen[-1]:.3f} ({abs(z) - 1.0:.3f})")
assert np.allclose(seen, [1.0, 0.2, -0.5, -0.5]), "mpscenes answers other distances now"
PYTHON
