"""Files in and out: untrusted input stops here, names become indices, units become SI."""
