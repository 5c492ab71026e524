"""Transfer recorded motions of bones, markers and segments to a body."""
