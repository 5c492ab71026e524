"""Pictures of reach envelopes."""
