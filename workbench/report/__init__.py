"""Results turned into words, tables and a page."""
