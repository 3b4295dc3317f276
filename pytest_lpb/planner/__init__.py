"""Planners: the base class, how they are found and configured, and those that come with the package."""
