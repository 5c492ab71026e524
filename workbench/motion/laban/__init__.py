"""Labanotation: scores of directions, levels and beats as motions, and back."""
