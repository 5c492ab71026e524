"""The report of an accommodation study."""
