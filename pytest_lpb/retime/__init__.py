"""Recorded calls made again and timed: timing that can be trusted, without running a trial."""
