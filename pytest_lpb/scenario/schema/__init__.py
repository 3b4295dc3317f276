"""The schema of scenario files: what may be written, checked key by key."""

from pytest_lpb.scenario.schema.file import ScenarioFile

__all__ = ["ScenarioFile"]
