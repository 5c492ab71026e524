"""Turnable pictures for browsers: scenes packed into pages, and the script that shows them."""
