"""Figures and the self-contained HTML report of a run. Importing this package loads nothing heavy."""
