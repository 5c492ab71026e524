"""Read STEP files with the optional cascadio (OpenCASCADE), in a process of its own.

On a broken file OpenCASCADE prints to stdout and may end the process with a signal, which Python
cannot catch.
"""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from workbench.errors import InputError, MissingPartError
from workbench.files.file_errors import BYTE_ORDER_MARK
from workbench.files.meshes.gltf import read_glb
from workbench.files.meshes.parts import RawMesh, free_memory

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
"""Program that reads argv[1], writes argv[2], and takes at most argv[3] bytes of memory if the system
can limit it. Tolerances are 0.1 mm and 0.3 rad (0.3 mm measured on a 127 mm part)."""
_UNNAMED = re.compile(r"|=>\[[0-9:]+\]|NAUO[0-9]+|[0-9]+")
"""What an occurrence of a product in an assembly is called that nobody named."""
_TIMEOUT = 900
"""Time [s] that OpenCASCADE may take."""
_MEMORY = 8 * 2**30
"""Memory [bytes] that OpenCASCADE may take if it is unknown how much is free."""


def read_step(path: Path, data: bytes) -> RawMesh:
    """Read the bodies of a STEP file, in metres.

    Raises
    ------
    MissingPartError
        If cascadio is not installed.
    InputError
        If the file is broken or takes over 15 minutes.
    """
    if find_spec("cascadio") is None:
        raise MissingPartError(f"{path}: STEP files need cascadio: pip install cascadio")
    data = data.removeprefix(BYTE_ORDER_MARK)
    if not data.lstrip().startswith(b"ISO-10303-21") or b"END-ISO-10303-21" not in data:
        raise InputError(
            f"{path}: not a STEP file, or cut short (ISO-10303-21 to END-ISO-10303-21)"
        )
    with TemporaryDirectory() as folder:
        source = Path(folder) / "given.step"
        mesh = Path(folder) / "made.glb"
        source.write_bytes(data)
        _convert(path, source, mesh)
        raw = read_glb(mesh, mesh.read_bytes(), unnamed=_UNNAMED)
    return replace(raw, file=str(path), format="STEP", up=None)


def _convert(path: Path, source: Path, mesh: Path) -> None:
    """Convert a STEP file to GLB; path: the file as the user named it."""
    memory = str(free_memory() or _MEMORY)
    command = [sys.executable, "-c", _CHILD, str(source), str(mesh), memory]
    try:
        child = subprocess.run(command, capture_output=True, timeout=_TIMEOUT, check=False)
    except subprocess.TimeoutExpired:
        raise InputError(
            f"{path}: takes OpenCASCADE more than {_TIMEOUT // 60} minutes: simplify it"
        ) from None
    if child.returncode != 0 or not mesh.is_file():
        raise InputError(
            f"{path}: broken STEP: OpenCASCADE cannot read it (exit {child.returncode})"
        )
