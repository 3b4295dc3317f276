"""What meshes, materials and textures may have; far more than robots need, and what can be read within seconds."""

MAX_MESH_BYTES = 100_000_000
MAX_MESH_VERTICES = 1_000_000
MAX_MESH_TRIANGLES = 1_000_000
MAX_MESH_COORDINATE = 1e9  # [units of the file], on either side of zero
MAX_LINE_BYTES = 1_000  # of text: PyBullet cuts lines of 1024, and takes the rest for a line of its own
MAX_MATERIAL_BYTES = 1_000_000
MAX_TEXTURE_BYTES = 100_000_000
MAX_TEXTURE_PIXELS = 8_192 * 8_192
MAX_LINES = 3_000_000  # of text
MESH_SUFFIXES = (".obj", ".stl", ".dae")  # kinds of files that PyBullet reads
