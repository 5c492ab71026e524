"""Motion: recorded movement on a body, Labanotation, signals."""
