"""Trials in motion: what a replay in the report is drawn from."""
