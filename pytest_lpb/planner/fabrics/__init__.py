"""Optimization fabrics, static and dynamic, as a planner: specs, maps, leaves, their composition, the planner."""
