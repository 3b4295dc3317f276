"""CasADi expressions against NumPy kinematics and their Jacobians."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.symbolic import casadi_kinematics
from tests.problem.spatial.robots import ENTRIES, mimic_robot, spatial_robot

EXACT = 1e-12


def compare(robot: SpatialRobot, kind: Any) -> None:
    """Poses, and the derivatives that CasADi finds, of all links."""
    q = kind.sym("q", robot.dof)
    generator = np.random.Generator(np.random.PCG64(11))
    for link in robot.link_names:
        position, rotation = casadi_kinematics(robot, q, link)
        assert (position.shape, rotation.shape) == ((3, 1), (3, 3))
        rates = casadi.jacobian(casadi.vec(rotation), q)
        function = casadi.Function("f", [q], [position, rotation, casadi.jacobian(position, q), rates])
        for row in generator.uniform(-2.0, 2.0, (3, robot.dof)):
            there, turned, linear, spins = (np.array(part) for part in function(row))
            pose, jacobian = robot.frame_and_jacobian(row, link)
            assert_allclose(there[:, 0], pose[:3, 3], atol=EXACT)
            assert_allclose(turned, pose[:3, :3], atol=EXACT)
            assert_allclose(linear, jacobian[:3], atol=EXACT)
            assert_allclose(angular(turned, spins), jacobian[3:], atol=EXACT)


def angular(rotation: FloatArray, rates: FloatArray) -> FloatArray:
    """Angular velocities (3, dof) from the rates (9, dof) of a rotation matrix, column by column."""
    spins = [rate.reshape(3, 3, order="F") @ rotation.T for rate in rates.T]
    return np.array([[spin[2, 1], spin[0, 2], spin[1, 0]] for spin in spins]).T


@pytest.mark.parametrize("name", ENTRIES)
def test_expressions_have_the_values_and_derivatives_of_the_robot(name: str) -> None:
    compare(spatial_robot(ENTRIES[name]), casadi.SX)


@pytest.mark.parametrize("name", ["panda", "racecar", "panda on wheels"])
def test_matrix_expressions_too(name: str) -> None:
    compare(spatial_robot(ENTRIES[name]), casadi.MX)


def test_joints_that_mimic(tmp_path: Path) -> None:
    compare(mimic_robot(tmp_path), casadi.SX)


def test_locked_joints_that_are_mimicked(tmp_path: Path) -> None:
    path = mimic_robot(tmp_path).urdf_path
    compare(spatial_robot({"urdf": path, "joints": ["open"], "locked_joints": {"lift": 0.4}}), casadi.SX)


@pytest.mark.parametrize("kind", [casadi.SX, casadi.MX])
def test_a_link_that_does_not_move_is_a_constant_of_the_same_type(kind: Any) -> None:
    robot = spatial_robot(ENTRIES["panda"])
    position, rotation = casadi_kinematics(robot, kind.sym("q", 7), "panda_link0")
    assert (type(position), type(rotation)) == (kind, kind)
    assert_allclose(np.array(casadi.evalf(position))[:, 0], robot.base_pose[:3, 3], atol=EXACT)


def test_numbers_give_numbers() -> None:
    robot = spatial_robot(ENTRIES["arm"])
    position, _ = casadi_kinematics(robot, casadi.DM([0.3, -0.2, 0.5]), "end")
    expected = robot.forward_kinematics([0.3, -0.2, 0.5], "end")[:3, 3]
    assert_allclose(np.array(position)[:, 0], expected, atol=EXACT)


def test_only_sines_and_cosines_of_planned_joints_are_left() -> None:
    """Fixed and locked joints cost nothing: the flange has one sine and one cosine for each of its seven joints."""
    q = casadi.SX.sym("q", 7)
    position, rotation = casadi_kinematics(spatial_robot(ENTRIES["panda"]), q, "panda_leftfinger")
    function = casadi.Function("f", [q], [position, rotation], {"cse": True})
    codes = [function.instruction_id(index) for index in range(function.n_instructions())]
    assert_array_equal([codes.count(casadi.OP_SIN), codes.count(casadi.OP_COS)], [7, 7])


def test_faults_are_named() -> None:
    robot = spatial_robot(ENTRIES["arm"])
    with pytest.raises(ValueError, match=r"no link 'ennd' in arm_3d.*did you mean 'end'"):
        casadi_kinematics(robot, casadi.SX.sym("q", 3), "ennd")
    with pytest.raises(ValueError, match="q has 4 entries; arm_3d has 3: joint1, joint2, joint3"):
        casadi_kinematics(robot, casadi.SX.sym("q", 4), "end")
