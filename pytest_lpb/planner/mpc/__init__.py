"""Model predictive control as a planner, in real time: model, stages, the quadratic program, solvers, the planner."""
