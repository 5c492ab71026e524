"""Simulate a crash by rigid-body dynamics.

The sphere body is a tree of rigid bodies. A pulse accelerates it; belts and parts restrain it.
"""
