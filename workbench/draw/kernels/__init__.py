"""Compiled loops of pictures: disks, depth buffers, light, and what triangles hide of lines and arcs."""
