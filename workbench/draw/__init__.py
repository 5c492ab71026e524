"""Displays: one scene, seen through a camera, as a raster picture of disks or a vector picture of
circles."""
