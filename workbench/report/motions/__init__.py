"""The report of a crash study."""
