"""Scripts that make the human family of sphere bodies; development time only. See make_human.py."""
