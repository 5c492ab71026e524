"""Spheres against polygons and spheres: trees, grids of distances, and the loops that search
them."""
