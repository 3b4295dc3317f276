#!/usr/bin/env bash
# forwardkinematics 1.2.3 (GenericXMLFk, which reads MuJoCo's XML) against mujoco 4.0.0, seen on 2026-12-01, Python 3.11:
# it chains every body and joint that stands before the wanted body in the file, those of other branches too: with two
# arms the right one stands on the left one's hand. And a body is turned by all joints but its own, so that even in a
# single chain its orientation lacks the last joint.
# Expected: a body's frame is composed along its own ancestors, its own joint included, as MuJoCo does.
# Output seen, x, y [m] and heading [rad] (MuJoCo's in brackets), two arms of two links beside each other:
#   left_hand: 0.921 0.889 0.4 (0.921 0.889 0.7)
#   right: 1.243 0.507 0.7 (0.000 -0.500 0.2)
#   right_hand: 1.865 1.290 0.9 (0.980 -0.301 0.3)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet forwardkinematics==1.2.3 mujoco==4.0.0 casadi==3.8.2 numpy==1.26.4
"$work/venv/bin/python" - <<'PYTHON'
import mujoco
import numpy as np
from forwardkinematics.xmlFks.generic_xml_fk import GenericXMLFk

ARMS = """<mujoco><worldbody>
  <body name="left" pos="0 0.5 0"><joint axis="0 0 1"/><geom size="0.1"/>
    <body name="left_hand" pos="1 0 0"><joint axis="0 0 1"/><geom size="0.1"/></body></body>
  <body name="right" pos="0 -0.5 0"><joint axis="0 0 1"/><geom size="0.1"/>
    <body name="right_hand" pos="1 0 0"><joint axis="0 0 1"/><geom size="0.1"/></body></body>
</worldbody></mujoco>"""
Q = np.array([0.4, 0.3, 0.2, 0.1])


def planar(position, rotation):
    return np.array([position[0], position[1], np.arctan2(rotation[1, 0], rotation[0, 0])])


model = mujoco.MjModel.from_xml_string(ARMS)
data = mujoco.MjData(model)
data.qpos[:] = Q
mujoco.mj_kinematics(model, data)
fk, seen, true = GenericXMLFk(ARMS, "world", []), {}, {}
for name in ("left_hand", "right", "right_hand"):
    frame, body = fk.numpy(Q, name), data.body(name)
    seen[name] = planar(frame[:3, 3], frame)
    true[name] = planar(body.xpos, body.xmat.reshape(3, 3))
    texts = ("{:.3f} {:.3f} {:.1f}".format(*values) for values in (seen[name], true[name]))
    print("{}: {} ({})".format(name, *texts))
assert np.allclose(true["right"], [0.0, -0.5, 0.2]), "MuJoCo answers otherwise now"
assert np.allclose(seen["right"], [1.243, 0.507, 0.7], atol=1e-3), "branches are composed otherwise now"
assert np.allclose(seen["left_hand"], [0.921, 0.889, 0.4], atol=1e-3), "a body's own joint is composed otherwise now"
PYTHON
