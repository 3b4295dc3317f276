"""Fair play: trials run again in other processes and orders, and whether planners look at the scene."""
