"""Which versions and which optional parts are there."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

from workbench.compiled import why_plain
from workbench.draw.logical_window import drawing_fault

__all__ = ["doctor_report"]

NEEDED = (
    "bubbleman-workbench",
    "numpy",
    "scipy",
    "numba",
    "trimesh",
    "manifold3d",
    "pydantic",
    "PyYAML",
    "pillow",
    "contourpy",
    "jinja2",
    "cyclopts",
    "rich",
    "pycollada",
    "lxml",
    "lazy_loader",
    "pyvista",
)
OPTIONAL = {
    "cascadio": "STEP files: pip install 'bubbleman-workbench[step]'",
    "mujoco": "simulated crashes: pip install 'bubbleman-workbench[dynamics]'",
    "starlette": "the live bench: pip install 'bubbleman-workbench[live]'",
    "uvicorn": "the live bench: pip install 'bubbleman-workbench[live]'",
    "imageio-ffmpeg": "MP4 films: pip install 'bubbleman-workbench[film]'",
}


def doctor_report() -> dict[str, str]:
    """Part name to what is there, or what is missing and how to get it."""
    report = {"python": f"{platform.python_version()} ({platform.system()} {platform.machine()})"}
    report |= {name: _version(name) or "MISSING: reinstall bubbleman-workbench" for name in NEEDED}
    report |= {name: _version(name) or f"not installed ({how})" for name, how in OPTIONAL.items()}
    if _version("numba"):
        report["numba"] += f", {_compiles()}"
    if _version("pyvista"):
        report["pyvista"] += f", {_off_screen()}"
    return report


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _compiles() -> str:
    """Which compiler makes the kernels."""
    reason = why_plain()
    return f"slow first runs: {reason}" if reason else "links kernels once"


def _off_screen() -> str:
    """Whether pyvista can draw without a screen here, tried in a child process."""
    fault = drawing_fault()
    return f"does not draw here: {fault}" if fault else "draws off screen"
