"""Scaling: bodies of other measures, and the measures of bodies."""
