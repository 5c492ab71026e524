"""Chains of joints: inverse kinematics, stops, and what limbs enter."""
