"""Compiled loops of pictures: rims, arcs, depth buffers, and what hides what."""
