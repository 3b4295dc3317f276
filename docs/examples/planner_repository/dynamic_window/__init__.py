"""A dynamic-window planner for a disc that moves in the plane."""

from dynamic_window.planner import DynamicWindow

__all__ = ["DynamicWindow"]
