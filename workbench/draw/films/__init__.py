"""Films, strips and the motions that they show."""
