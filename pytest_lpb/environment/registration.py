"""Makes `lpb/Scenario-v0` known to gymnasium."""

import gymnasium

ENVIRONMENT_ID = "lpb/Scenario-v0"


def register_environment() -> None:
    """Register the environment; again is no harm."""
    if ENVIRONMENT_ID not in gymnasium.registry:
        gymnasium.register(ENVIRONMENT_ID, entry_point="pytest_lpb.environment.environment:ScenarioEnvironment")
