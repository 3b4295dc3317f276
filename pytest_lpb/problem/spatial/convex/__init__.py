"""Signed distances of convex shapes at double precision, by their support points."""
