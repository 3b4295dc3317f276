"""Planar robots, goals and shapes: scalar arithmetic, since an array costs more than ten flops at this size."""
