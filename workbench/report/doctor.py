"""Which versions and which optional parts are there."""

from __future__ import annotations

import platform
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version

__all__ = ["doctor_report"]

NEEDED = ("bubbleman-workbench", "numpy", "scipy", "numba", "trimesh", "manifold3d", "pydantic", "PyYAML", "pillow",
          "jinja2", "cyclopts", "rich", "pycollada", "lxml")  # fmt: skip
OPTIONAL = {"cascadio": "STEP files: pip install 'bubbleman-workbench[step]'"}
# VTK ends the process with a signal where there is no EGL: only a child process can find that out.
PROBE = (
    "import pyvista; p = pyvista.Plotter(off_screen=True, window_size=(16, 16)); p.add_mesh(pyvista.Sphere()); p.show()"
)


def doctor_report() -> dict[str, str]:
    """Part name to what is there, or what is missing and how to get it."""
    report = {"python": f"{platform.python_version()} ({platform.system()} {platform.machine()})"}
    report |= {name: _version(name) or "MISSING: reinstall bubbleman-workbench" for name in NEEDED}
    report |= {name: _version(name) or f"not installed ({how})" for name, how in OPTIONAL.items()}
    installed = _version("pyvista")
    report["pyvista"] = f"{installed}, {_off_screen()}" if installed else "MISSING: reinstall bubbleman-workbench"
    return report


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _off_screen() -> str:
    """Whether pyvista can draw without a screen here, tried in a child process."""
    try:
        done = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, timeout=90, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return "does not draw here (it did not start in 90 s); nothing depends on it yet"
    return "draws off screen" if done.returncode == 0 else "does not draw here (no EGL); nothing depends on it yet"
