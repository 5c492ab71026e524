"""Fit few spheres to a closed surface within a proved tolerance."""
