"""Compiled code that is kept is forgotten when any kernel changes.

The compiler keeps what it made of a file until that file changes, though it holds what other files' functions were when
they were drawn into it. So after a new version of one of them is fetched into a folder that is run from, old code would
go on running beside new. Here all files count together. Where the folder cannot be written to, files come and go
together, and the compiler's own rule is enough.
"""

from __future__ import annotations

import hashlib
from contextlib import suppress
from pathlib import Path

__all__ = ["forget_stale"]

_STAMP = "kernels.stamp"


def forget_stale(folder: Path) -> bool:
    """Remove the compiled code kept under a folder of kernels where their files are not those it was made from; whether
    it was removed."""
    sources = sorted(folder.rglob("*.py"))
    stats = [(str(path.relative_to(folder)), path.stat()) for path in sources]
    text = "".join(f"{name} {stat.st_size} {stat.st_mtime_ns}\n" for name, stat in stats)
    now, stamp = hashlib.sha256(text.encode()).hexdigest(), folder / "__pycache__" / _STAMP
    with suppress(OSError):
        if stamp.is_file() and stamp.read_text() == now:
            return False
        for path in [*folder.rglob("__pycache__/*.nbi"), *folder.rglob("__pycache__/*.nbc")]:
            path.unlink(missing_ok=True)
        stamp.parent.mkdir(exist_ok=True)
        stamp.write_text(now)
        return True
    return False
