"""Geometry: distances between points, spheres, polygons and trees of boxes, as compiled loops that
know no body."""
