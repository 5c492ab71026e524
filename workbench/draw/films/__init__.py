"""Films, strips and the motions they show."""
