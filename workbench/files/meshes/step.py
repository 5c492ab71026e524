"""STEP, cut into triangles by the optional cascadio (OpenCASCADE) in a process of its own.

On a broken file OpenCASCADE talks on stdout and may end the process with a signal, which Python
cannot catch.
"""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from workbench.errors import InputError, MissingPartError
from workbench.files.meshes.bounds import free_memory
from workbench.files.meshes.gltf import read_glb
from workbench.files.meshes.parts import RawMesh
from workbench.files.opening import BYTE_ORDER_MARK

__all__ = ["read_step"]

_CHILD = """
import sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[3]), int(sys.argv[3])))
except ImportError:
    pass
import cascadio
cascadio.step_to_glb(sys.argv[1], sys.argv[2], tol_linear=0.1, tol_angular=0.3)
"""
"""Reads argv[1], writes argv[2], and takes at most argv[3] bytes of memory where the system can
limit it."""
_LONGEST = 900
_MEMORY = 8 * 2**30
"""Memory [bytes] that OpenCASCADE may take where it is unknown how much is free."""


def read_step(path: Path, data: bytes) -> RawMesh:
    """The bodies of a STEP file in metres; asked of OpenCASCADE: 0.1 mm, 0.3 rad (0.3 mm measured
    on a 127 mm part).

    MissingPartError where cascadio is not installed, InputError where the file is broken or takes
    over 15 minutes.
    """
    if find_spec("cascadio") is None:
        raise MissingPartError(f"{path}: STEP files need cascadio: pip install cascadio")
    data = data.removeprefix(BYTE_ORDER_MARK)
    if not data.lstrip().startswith(b"ISO-10303-21") or b"END-ISO-10303-21" not in data:
        raise InputError(
            f"{path}: not a STEP file, or cut short (ISO-10303-21 to END-ISO-10303-21)"
        )
    with TemporaryDirectory() as folder:
        given = Path(folder) / "given.step"
        made = Path(folder) / "made.glb"
        given.write_bytes(data)
        command = [
            sys.executable,
            "-c",
            _CHILD,
            str(given),
            str(made),
            str(free_memory() or _MEMORY),
        ]
        try:
            done = subprocess.run(command, capture_output=True, timeout=_LONGEST, check=False)
        except subprocess.TimeoutExpired:
            raise InputError(
                f"{path}: takes OpenCASCADE more than {_LONGEST // 60} minutes: simplify it"
            ) from None
        if done.returncode != 0 or not made.is_file():
            raise InputError(
                f"{path}: broken STEP: OpenCASCADE cannot read it (exit {done.returncode})"
            )
        found = read_glb(made, made.read_bytes())
    return replace(found, file=str(path), format="STEP", up=None)
