#!/usr/bin/env bash
# mpscenes 0.4.6 (scenes of localPlannerBench and urdfenvs), seen on 2026-12-01 with Python 3.11:
# a spline trajectory answers position, velocity and acceleration; the velocity is not the derivative of the position.
# It has the right direction, but its length is that of the time scaling alone: of a spline of any size, run through in
# 10 s, it is at most pi / 10. Here it is 0.37 to 0.50 of the true speed, and of a spline ten times as large 0.037 to 0.050.
# Expected: the derivative. A planner that tracks a goal by its velocity lags behind, by more the larger the spline.
# Output seen:
#   size 1: given / true speed 0.498 0.447 0.371
#   size 10: given / true speed 0.050 0.045 0.037
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet mpscenes==0.4.6 geomdl==5.4.0 'numpy<2'
"$work/venv/bin/python" - <<'PYTHON'
import numpy as np
from mpscenes.common.spline_trajectory import SplineTrajectory

POINTS = np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 2.0]])
STEP = 1e-4  # [s]
ratios = {}
for size in (1, 10):
    spline = SplineTrajectory(2, traj={"degree": 2, "controlPoints": (size * POINTS).tolist(), "duration": 10})
    row = []
    for t in (2.0, 5.0, 8.0):
        after, before = (np.array(spline.evaluate(t + step)[0]) for step in (STEP, -STEP))
        true = np.linalg.norm(after - before) / (2 * STEP)
        row.append(np.linalg.norm(spline.evaluate(t)[1]) / true)
    ratios[size] = row
    print(f"size {size}: given / true speed", *(f"{ratio:.3f}" for ratio in row))
assert np.allclose(ratios[1], [0.498, 0.447, 0.371], atol=2e-3), "mpscenes answers other velocities now"
assert np.allclose(np.array(ratios[1]) / ratios[10], 10.0, rtol=1e-3), "the velocity depends on the size now"
PYTHON
