"""Marks: contacts, clearances, labels and the scale bar."""
