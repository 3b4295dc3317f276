"""Planners: the base class, how they are found and configured, and the two that come with the package."""
