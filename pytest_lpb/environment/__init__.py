"""The environment of a trial: a gymnasium environment over a simulation engine.

Importing this package makes `gymnasium.make("lpb/Scenario-v0", scenario=PATH)` work.
"""

from pytest_lpb.environment.registration import register_environment

register_environment()
