"""Crash studies: contacts of a motion in continuous time, signals, verdicts."""
