"""Perform scores in Labanotation, and read motions as scores."""
