"""Vector displays: circles and outlines, with what is hidden removed."""
