"""Reaching: limbs to targets, within the stops and clear of obstacles."""
