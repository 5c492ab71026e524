"""A study under the hands of its user: states, edits, answers and their history."""
