"""What a result was made from and by: the inputs' hashes and the versions of what computed."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from workbench.model.population import Population

__all__ = ["hashes", "people_hash", "versions"]

PACKAGES = ("bubbleman-workbench", "numpy", "scipy", "numba", "trimesh", "manifold3d")


def hashes(inputs: Mapping[str, Path]) -> dict[str, str]:
    """SHA-256 of each input file, by its role."""
    return {
        f"{role}": hashlib.sha256(path.read_bytes()).hexdigest()
        for role, path in sorted(inputs.items())
    }


def people_hash(people: Population) -> str:
    """SHA-256 of who the people are: the measures' names and values, sexes and weights; not of what
    they are called."""
    digest = hashlib.sha256("\n".join(people.names).encode())
    for array in (people.sex, people.weight, people.measures):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def versions() -> dict[str, str]:
    """Versions of Python and of the packages whose numbers a result rests on."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found
