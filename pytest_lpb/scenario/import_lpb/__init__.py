"""Experiment files of localPlannerBench (exp.yaml) as scenario files."""
