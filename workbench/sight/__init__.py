"""Sight: what eyes see, what hides it, by how much."""
