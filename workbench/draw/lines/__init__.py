"""Vector displays: outlines, circles, and edges with hidden lines removed."""
