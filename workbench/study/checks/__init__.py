"""Checks: a file for each subject, listed in `table`.

A check answers in up to three ways. `margins` gives one number for each person of a batch.
`findings` lists everything that one person comes near to or misses, for the page. `moments` finds
the worst moment of a motion.
"""
