"""Crash studies and simulations, with their restraints and pulses."""
