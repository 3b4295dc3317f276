"""Planners in processes of their own: other interpreters, other hosts, other languages, and hard limits."""
