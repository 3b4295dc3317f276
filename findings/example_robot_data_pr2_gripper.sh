#!/usr/bin/env bash
# example-robot-data 6.0.0 (pr2.urdf) with pin 4.1.0, seen on 2026-12-01 with Python 3.11:
# in each gripper the joint `[rl]_gripper_r_parallel_root_joint` mimics with multiplier -1 about an axis
# that is mirrored already, and has the limits [0, 0.548]: the finger's motion [0, 0.548] takes it to [-0.548, 0].
# Whoever holds followers to their own limits freezes the gripper (the range that is left is 0 to 0); whoever does not
# turns both parallel links to the same side, where they should mirror each other.
# Expected: multiplier 1, as the finger beside it has.
# Output seen:
#   r_gripper_r_parallel_root_joint: multiplier -1, limits 0 to 0.548, range left of the finger 0 to 0
#   l_gripper_r_parallel_root_joint: multiplier -1, limits 0 to 0.548, range left of the finger 0 to 0
#   fingers at 0.3: left +0.3, right -0.3; their parallel links: left +0.3, right +0.3
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet pin==4.1.0 example-robot-data==6.0.0
"$work/venv/bin/python" - "$(find "$work/venv" -name pr2.urdf)" <<'PYTHON'
import sys
import xml.etree.ElementTree as ElementTree

import pinocchio

file = sys.argv[1]
frozen = []
for joint in ElementTree.parse(file).getroot().iter("joint"):
    mimic, limit = joint.find("mimic"), joint.find("limit")
    if mimic is None or limit is None or float(limit.get("lower")) != 0.0:
        continue
    multiplier, upper = float(mimic.get("multiplier")), float(limit.get("upper"))
    if multiplier < 0.0:
        print(f"{joint.get('name')}: multiplier {multiplier:g}, limits 0 to {upper:g}, range left of the finger 0 to 0")
        frozen.append(joint.get("name"))
assert sorted(frozen) == [f"{side}_gripper_r_parallel_root_joint" for side in "lr"], "the file has other followers now"

model = pinocchio.buildModelFromUrdf(file, mimic=True)
data, q = model.createData(), pinocchio.neutral(model)
q[model.joints[model.getJointId("r_gripper_l_finger_joint")].idx_q] = 0.3
pinocchio.forwardKinematics(model, data, q)


def turned(name):
    joint = model.getJointId(f"r_gripper_{name}_joint")
    before, after = data.oMi[model.parents[joint]].rotation, data.oMi[joint].rotation
    fixed = model.jointPlacements[joint].rotation
    return float(pinocchio.log3(fixed.T @ before.T @ after)[2])


seen = [turned(name) for name in ("l_finger", "r_finger", "l_parallel_root", "r_parallel_root")]
fingers, links = (f"left {left:+.1f}, right {right:+.1f}" for left, right in (seen[:2], seen[2:]))
print(f"fingers at 0.3: {fingers}; their parallel links: {links}")
assert [round(angle, 6) for angle in seen] == [0.3, -0.3, 0.3, 0.3], "the gripper moves otherwise now"
PYTHON
