"""Describe people: percentiles, boundary cases, random draws, growth, and accommodated shares."""
