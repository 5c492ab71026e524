"""Study files: their shape, what may be wrong with them, and reading them."""
