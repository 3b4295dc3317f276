"""One trial: a pure function of a concrete problem and a planner configuration."""
