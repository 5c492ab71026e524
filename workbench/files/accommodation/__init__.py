"""Accommodation studies and their results."""
