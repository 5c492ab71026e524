"""Marks in pictures: contacts, clearances, targets, axes, and their labels."""
