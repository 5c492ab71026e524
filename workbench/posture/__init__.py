"""Posture: joint stops, inverse kinematics, seating and driving."""
