"""KPIs: numbers that say how well one trial went, computed from its raw data alone."""
