"""Environments of bare meshes, as Python asks for them: what a mesh does not say is guessed and
reported."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

from workbench.errors import UsageError
from workbench.files import environments
from workbench.files.catalogue import is_file
from workbench.files.meshes.parts import RawMesh
from workbench.files.meshes.reading import FORMATS, read_mesh
from workbench.files.meshes.scene import mesh_of_scene
from workbench.files.meshes.taken_frame import taken_frame
from workbench.model.arguments import caller_level
from workbench.model.environment import Environment

__all__ = ["environment_of_scene", "is_place", "load_environment"]


def is_place(source: str) -> bool:
    """Whether a text is the path of a mesh, by its ending, or of an environment's folder."""
    return _is_mesh(source) or _folder(source) is not None


def _is_mesh(source: str | Path) -> bool:
    return Path(source).suffix.lower() in FORMATS


def load_environment(
    source: str | Path,
    *,
    near: Path | None = None,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> Environment:
    """Load an environment, or a bare mesh as one.

    Parameters
    ----------
    source
        A folder with `environment.yaml`, a name of the catalogue, a YAML file, or a mesh file. What
        neither the mesh nor the call says is guessed, as `workbench live` does it: a warning of
        Python tells what and why, and so do the environment's `warnings`.
    near
        The folder of the file that names it.
    length, up, forward
        Of a mesh: its unit (mm, cm, m, in, ft, or one unit's length such as "150 mm"), and its axes
        (x, y, z, -x, -y, -z) that point up and forward.

    Raises
    ------
    InputError
        With a line for each fault; those of a YAML file with file, line and column.
    UsageError
        If the axes are none, or what belongs to a mesh is given for something else.

    Examples
    --------
    >>> import workbench as wb
    >>> trainer = wb.load_environment("trainer")
    >>> len(trainer.parts), trainer.seat("left").travel_forward  # [m]
    (85, (-0.09, 0.09))
    """
    if _is_mesh(source):
        path = Path(source) if near is None else near / source
        return _taken(read_mesh(path), path.stem, length=length, up=up, forward=forward)
    for name, given in (("length", length), ("up", up), ("forward", forward)):
        if given is not None:
            raise UsageError(
                f"{name}: belongs to a mesh file ({', '.join(FORMATS)}); {source} says it itself"
            )
    return environments.load_environment(_folder(source) or source, near=near)


def _folder(source: str | Path) -> Path | None:
    """The folder of an environment that lies where the program runs; None where there is none of
    this name."""
    return Path(source) if is_file(Path(source) / "environment.yaml") else None


def environment_of_scene(scene: Any) -> Environment:
    """Take a mesh or a scene of trimesh for an environment. See `load_environment`.

    Its unit is that of its `units`, its axes are those of its metadata ("up", "forward"): what is
    not there is guessed.
    """
    return _taken(mesh_of_scene(scene, "scene"), "scene")


def _taken(
    raw: RawMesh,
    name: str,
    *,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> Environment:
    """A mesh with its unit and axes as they are stated, else guessed."""
    frame = taken_frame(raw, length=length, up=up, forward=forward)
    assumed = list(frame.assumed())
    if assumed:
        warnings.warn(
            f"{raw.file}: assumed, as nothing says it: {'; '.join(assumed)}. Where that is wrong, "
            "state length, up and forward (wb.load_environment, wb.environment_from_mesh)",
            stacklevel=caller_level(),
        )
    notes = [f"{raw.file}: assumed: {words}" for words in assumed]
    return environments.bare_environment(
        raw, name, metres=frame.metres, rotation=frame.rotation, notes=notes
    )
