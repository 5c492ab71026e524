"""People: percentile persons, boundary cases, random draws, growing children, and how many of them
are served."""
