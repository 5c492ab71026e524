"""Fitting: a closed surface as few spheres within a proved tolerance."""
