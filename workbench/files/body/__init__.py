"""Bodies, what they wear, and the outlines they are made from."""
