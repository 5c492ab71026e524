"""Making an environment of a mesh by pointing: a description, edits of it, and saving it."""
