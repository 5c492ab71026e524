"""What a result was made from and by: the inputs' hashes and the versions of what computed."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

__all__ = ["hashes", "versions"]

PACKAGES = ("bubbleman-workbench", "numpy", "scipy", "numba", "trimesh")


def hashes(inputs: Mapping[str, Path]) -> dict[str, str]:
    """SHA-256 of each input file, by its role."""
    return {f"{role}": hashlib.sha256(path.read_bytes()).hexdigest() for role, path in sorted(inputs.items())}


def versions() -> dict[str, str]:
    """Versions of Python and of the packages whose numbers a result rests on."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found
