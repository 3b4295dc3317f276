"""Robots, goals and obstacles in space: URDF models, kinematics in NumPy, exact clearance through PyBullet."""
