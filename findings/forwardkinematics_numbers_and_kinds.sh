#!/usr/bin/env bash
# forwardkinematics 1.0.1 (of localPlannerBench 1.0), seen on 2026-12-01 with Python 3.11 and casadi 3.8.2:
# 1. `GroundRobotFk.fk(q, 1)` depends on the kind of q: of a NumPy array it lies 0.2 m ahead of what it is of a CasADi
#    symbol. A planner that composes it in CasADi and a KPI that evaluates it in NumPy measure two places.
# 2. Links of `PandaFk` by number are not the Panda's: 1 is panda_link3, and the last one, 7, is a frame that the Panda
#    does not have, 20 mm beyond the flange (panda_link8).
# Expected: one place per call, whatever the kind of q; numbers that count the links.
# Output seen:
#   ground robot, link 1: NumPy [1.1755, 2.0959, 0.5], CasADi [1.0, 2.0, 0.5]
#   panda, link 1: panda_link3
#   panda, link 7: panda_link9, 0.0200 m from panda_link8
# (Its metadata name Python < 3.11 and a pre-release of casadi 3.5.6 that is gone; the code runs as it is.)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet casadi==3.8.2 numpy==1.26.4 urdf_parser_py==0.0.4
"$work/venv/bin/pip" install --quiet --no-deps --ignore-requires-python forwardkinematics==1.0.1
"$work/venv/bin/python" - 2>"$work/log" <<'PYTHON'
import casadi
import numpy as np
from forwardkinematics.planarFks.groundRobotFk import GroundRobotFk
from forwardkinematics.urdfFks.pandaFk import PandaFk

ground, q, symbol = GroundRobotFk(3), np.array([1.0, 2.0, 0.5]), casadi.SX.sym("q", 3)
number = ground.fk(q, 1)
symbolic = np.array(casadi.Function("fk", [symbol], [ground.fk(symbol, 1)])(q)).ravel()
print(f"ground robot, link 1: NumPy {number.round(4).tolist()}, CasADi {symbolic.round(4).tolist()}")
assert np.isclose(np.linalg.norm((number - symbolic)[:2]), 0.2), "both kinds of q give the same place now"

panda, q = PandaFk(), np.array([0.1, -0.4, 0.2, -1.8, 0.3, 1.6, 0.5])
place = {name: panda.fk(q, name, positionOnly=True).ravel() for name in ("panda_link3", "panda_link8", "panda_link9")}
first, last = panda.fk(q, 1, positionOnly=True).ravel(), panda.fk(q, 7, positionOnly=True).ravel()
assert np.allclose(first, place["panda_link3"]), "link 1 is another link now"
print("panda, link 1: panda_link3")
beyond = np.linalg.norm(last - place["panda_link8"])
print(f"panda, link 7: panda_link9, {beyond:.4f} m from panda_link8")
assert np.allclose(last, place["panda_link9"]) and np.isclose(beyond, 0.02), "link 7 is another link now"
PYTHON
