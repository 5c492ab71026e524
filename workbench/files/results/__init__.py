"""The published shape of result.json and comparison.json."""
