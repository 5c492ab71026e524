"""Pictures: rims, arcs, depth buffers, and what hides what."""
