#!/usr/bin/env bash
# example-robot-data 6.0.0 (alex_psyonic_hands.urdf), pin 4.1.0 and yourdfpy 0.0.60, seen on 2026-12-01 with Python 3.11:
# eight finger joints mimic `index_q1`, `middle_q1`, .., which the file does not have (it has Left_index_q1 and
# Right_index_q1). The same file is three robots:
#   pinocchio: 39 joints, the eight move freely; with mimic=True it is a ValueError;
#   yourdfpy: 31 joints, the eight stand still at their offset of 0.723 rad (a warning in the log).
# Expected: joints that are there, or one reading.
# Output seen:
#   followers of joints that are not there: 8
#   pinocchio: 39 positions; mimic=True: ValueError
#   yourdfpy: 31 joints
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet pin==4.1.0 example-robot-data==6.0.0 yourdfpy==0.0.60
"$work/venv/bin/python" - "$(find "$work/venv" -name alex_psyonic_hands.urdf)" <<'PYTHON'
import logging
import sys
import xml.etree.ElementTree as ElementTree

import pinocchio
import yourdfpy

logging.disable()
file = sys.argv[1]
joints = [joint for joint in ElementTree.parse(file).getroot().iter("joint") if joint.find("parent") is not None]
names = {joint.get("name") for joint in joints}
lost = [j.get("name") for j in joints if j.find("mimic") is not None and j.find("mimic").get("joint") not in names]
print("followers of joints that are not there:", len(lost))
free = pinocchio.buildModelFromUrdf(file).nq
try:
    following = str(pinocchio.buildModelFromUrdf(file, mimic=True).nq)
except ValueError as error:
    following = type(error).__name__
print(f"pinocchio: {free} positions; mimic=True: {following}")
robot = yourdfpy.URDF.load(file, load_meshes=False)
print(f"yourdfpy: {len(robot.actuated_joint_names)} joints")
assert len(lost) == 8 and not set(lost) & set(robot.actuated_joint_names), "the file or yourdfpy's reading is another now"
assert (free, following, len(robot.actuated_joint_names)) == (39, "ValueError", 31), "the readings are others now"
PYTHON
