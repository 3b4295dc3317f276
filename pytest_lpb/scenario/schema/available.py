"""What this version can run of what the schema can express."""

AVAILABLE_ENGINES = ("planar",)
AVAILABLE_MODELS = ("differential_drive", "planar_arm", "point")
AVAILABLE_URDF = False  # URDF robots need the engine pybullet
AVAILABLE_CONTROLS = {"planar": ("acceleration", "velocity")}  # per engine
AVAILABLE_SHAPES = {"planar": ("circle", "rectangle")}  # per engine
