"""Mesh files in: every format read into named parts, faults counted, faces merged into planar
polygons."""
