"""Bodies: forward placement; bodies from outlines, meshes and measures, and measures from bodies."""
