"""Unions of spheres as shapes: covers, spacing, volumes."""
