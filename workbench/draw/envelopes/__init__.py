"""Reach envelopes in pictures."""
