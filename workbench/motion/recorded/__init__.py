"""Recorded motion: bones and markers of a subject, told of a body."""
