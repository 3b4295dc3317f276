"""Families of problems to run: of a scenario file, of an old run, or as a study file says."""
