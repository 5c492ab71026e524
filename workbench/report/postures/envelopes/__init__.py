"""The part of a report about reach envelopes."""
