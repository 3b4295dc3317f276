"""A problem as planners composed in CasADi see it: parts of the robot, obstacles and sub-goals as expressions."""
