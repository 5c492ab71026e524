"""Compiled loops of spheres against polygons and spheres: clearance, contacts, sweeps."""
