"""What the engines can run of what the schema can express."""

PLANAR_MODELS = ("differential_drive", "planar_arm", "point")
AVAILABLE_CONTROLS = {  # per engine
    "planar": ("acceleration", "velocity"),
    "pybullet": ("acceleration", "velocity", "torque"),
}
AVAILABLE_SHAPES = {  # per engine
    "planar": ("circle", "rectangle"),
    "pybullet": ("sphere", "box", "cylinder", "capsule", "mesh"),
}
SAME_SHAPE = {"circle": "sphere", "rectangle": "box", "sphere": "circle", "box": "rectangle"}  # in the other dimension
DIMENSIONS = {"planar": 2, "pybullet": 3}  # of the engines
