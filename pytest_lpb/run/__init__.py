"""From the raw data of a run to its tables."""
