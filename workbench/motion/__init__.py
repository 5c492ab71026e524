"""Compute motions of a body from recordings and scores, and signals from motions."""
