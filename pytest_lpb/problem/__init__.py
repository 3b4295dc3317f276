"""The concrete problem of one trial: robot, environment settings, start, goal, obstacles."""
