"""Compiled loops over joints and over unions of spheres."""
