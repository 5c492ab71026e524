"""Compiled loops of sight: pictures of all directions from an eye, lines from eyes to points."""
