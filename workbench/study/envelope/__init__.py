"""Reach envelopes about the seat reference point: rays, their ends, what obstacles take, comfort,
people."""
