"""A crash by rigid-body dynamics: the sphere body as a tree of masses, pushed by a pulse, held by
belts and parts."""
