"""Compiled loops over chains of joints: inverse kinematics, stops, and what limbs enter."""
