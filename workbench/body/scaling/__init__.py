"""Fit bodies to given measures, and measure bodies."""
