"""Environments from `environment.yaml` and its meshes, or from one bare mesh."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.catalogue import find, is_folder
from workbench.files.environment_adjustments import (
    adjustment_faults,
    adjustments_of,
)
from workbench.files.environment_controls import gripped, with_controls
from workbench.files.environment_cushions import cushion_front
from workbench.files.environment_doubts import environment_doubts
from workbench.files.environment_faces import with_faces
from workbench.files.environment_parts import arranged_mesh, is_piece, matching_parts
from workbench.files.environment_schema import (
    EnvironmentFile,
    MeshFile,
    PartFile,
    RestFile,
    SeatFile,
    unit_metres,
)
from workbench.files.meshes.assembly import build_environment
from workbench.files.meshes.obj import outside_folder
from workbench.files.meshes.parts import RawMesh, RawPart
from workbench.files.meshes.reading import (
    SMALLEST,
    SMALLEST_OF_SEVERAL,
    axes_rotation,
    extent,
    implausible,
    read_mesh,
    stated_axes,
    to_world,
)
from workbench.files.meshes.scene import mesh_of_scene
from workbench.files.meshes.sizes import implausible_sizes
from workbench.files.schema import fail, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.arrays import Floats
from workbench.model.doubt import Doubt, open_doubts
from workbench.model.environment import Allowance, Environment, Rest, Seat
from workbench.model.posing import attitude_matrix

__all__ = [
    "MeshFrame",
    "bare_environment",
    "environment_files",
    "environment_from_mesh",
    "load_environment",
    "mesh_frame",
    "seat_of",
    "size_doubts",
    "unknown_names",
]

_INNER = "environment.yaml"
_UNEVEN = 0.001
"""Slack [m] on the depth a sitter sinks in: no cushion in a mesh is quite flat."""


def load_environment(source: str | Path, *, near: Path | None = None) -> Environment:
    """Load an environment: a folder with `environment.yaml`, a YAML file, or a name in the
    catalogue.

    near: the folder of the file that names it. InputError carries a line for every fault found,
    with file, line and column in the YAML.
    """
    path = _path(source, near)
    document = read_yaml(path)
    file = validate(document, EnvironmentFile)
    parts, notes, sizes = _meshes(document, file, path.parent)
    names = [part.name for part in parts]
    rules, faults = _rules(document, file, names)
    faults += unknown_names(document, file, names)
    faults += adjustment_faults(document, file, names)
    if faults:
        raise InputError(faults)
    environment, open_parts = build_environment(
        file.environment, parts, solid=[rule.solid for rule in rules]
    )
    if open_parts:
        raise InputError(
            [fail(document, _rule_path(file, names[k]), what) for k, what in open_parts]
        )
    return _complete(document, environment, file, rules, notes, sizes)


def environment_files(source: str | Path, *, near: Path | None = None) -> tuple[Path, ...]:
    """The files an environment is made of: the YAML file, then its meshes."""
    path = _path(source, near)
    file = validate(read_yaml(path), EnvironmentFile)
    return (path, *(path.parent / mesh.file for mesh in file.meshes))


def environment_from_mesh(
    source: Any,  # a path, or an object of a library that is loaded only where it is used
    *,
    up: str,
    forward: str,
    length: str | None = None,
    solid: bool | str = "auto",
) -> Environment:
    """Make an environment from one mesh, without rules, seats or points.

    Parameters
    ----------
    source
        A mesh file, or what trimesh has loaded or made: a scene, whose geometries are the parts, or
        one mesh.
    up, forward
        Axes of the mesh (x, y, z, -x, -y, -z) that point up and forward.
    length
        Its unit (mm, cm, m, in, ft, or one unit's length such as "150 mm") where the mesh does not
        say it, or is wrong.
    solid
        "auto" (closed parts are), True or False for every part.

    Raises
    ------
    InputError
        If the mesh cannot be read, holds no surface, has a size that no vehicle has, or a part
        cannot be solid.
    UsageError
        If `source` is something else, or the axes are no axes.

    Examples
    --------
    >>> import trimesh
    >>> import workbench as wb
    >>> cab = wb.environment_from_mesh(
    ...     trimesh.creation.box((1.2, 1.5, 1.4)), up="z", forward="x", length="m"
    ... )
    >>> len(cab.parts), cab.part(cab.parts[0]).solid
    (1, True)
    """
    is_file = isinstance(source, str | Path)
    name = Path(source).stem if is_file else "scene"
    raw = read_mesh(source) if is_file else mesh_of_scene(source, name)
    rotation = axes_rotation(up, forward)
    metres = _stated(raw.file, length) if length is not None else raw.metres
    return bare_environment(raw, name, metres=metres, rotation=rotation, solid=solid)


def bare_environment(
    raw: RawMesh,
    name: str,
    *,
    metres: float | None,
    rotation: Floats,
    solid: bool | str = "auto",
    notes: Sequence[str] = (),
) -> Environment:
    """Make an environment of a mesh as it was read.

    Parameters
    ----------
    raw, name
        The mesh, and the name of the environment.
    metres, rotation
        Unit of the mesh [m], None where it is not known; (3, 3) from its axes.
    solid
        As for `environment_from_mesh`.
    notes
        Sentences about it that come first among the warnings.

    Raises
    ------
    InputError
        As `environment_from_mesh`.
    """
    wrong = implausible(float(extent(raw.parts).max()), metres)
    if wrong or metres is None:
        raise InputError(f"{raw.file}: {wrong}")
    parts = to_world(raw, rotation, metres=metres)
    notes = (*notes, *implausible_sizes(parts, metres, file=name), *raw.notes)
    environment, faults = build_environment(name, parts, solid=[solid] * len(parts), notes=notes)
    if faults:
        raise InputError([f"{raw.file}: {what}" for _, what in faults])
    return environment


def _path(source: str | Path, near: Path | None) -> Path:
    if isinstance(source, Path):
        return source / _INNER if is_folder(source) else source
    return find("environments", source, _INNER, near=near)


def _stated(source: str, length: str) -> float:
    try:
        return unit_metres(length)
    except ValueError as error:
        raise InputError(f"{source}: length {length!r}: {error}") from None


def _meshes(
    document: Document, file: EnvironmentFile, folder: Path
) -> tuple[list[RawPart], list[str], list[Doubt]]:
    """All parts of all meshes in the world's frame, notes about them, and doubts about their
    sizes; every fault of every mesh at once."""
    parts: list[RawPart] = []
    notes: list[str] = []
    doubts: list[Doubt] = []
    faults: list[str] = []
    for row, mesh in enumerate(file.meshes):
        key = ("meshes", row, "file")
        try:
            found, said, odd = _mesh(folder, mesh, alone=len(file.meshes) == 1)
        except InputError as error:
            faults += [fail(document, key, problem) for problem in error.problems]
            continue
        taken = {part.name for part in parts}
        twice = [part.name for part in found if part.name in taken]
        faults += [fail(document, key, _twice(file, row, name)) for name in twice]
        parts += found
        notes += [f"{mesh.file}: {note}" for note in said]
        doubts += odd
    if not faults and (wrong := implausible(float(extent(tuple(parts)).max()), 1.0)):
        faults.append(fail(document, ("meshes",), wrong))
    if faults:
        raise InputError(faults)
    return parts, notes, doubts


def _twice(file: EnvironmentFile, row: int, name: str) -> str:
    """That a part of a mesh is in another one too, and what helps."""
    new = f"{Path(file.meshes[row].file).stem}_{name}"
    return (
        f"part {name!r} is in another mesh too: give this one another name, "
        f"join: {{{new}: [{name}]}}"
    )


def _mesh(
    folder: Path, mesh: MeshFile, *, alone: bool
) -> tuple[tuple[RawPart, ...], tuple[str, ...], list[Doubt]]:
    """The parts of a mesh in the world's frame, notes about it, and doubts about its sizes. alone:
    it is all there is."""
    if outside_folder(mesh.file):
        raise InputError(
            f"{mesh.file}: a mesh lies in the folder of its environment file, or below it"
        )
    raw = read_mesh(folder / mesh.file)
    frame = mesh_frame(raw, mesh)
    smallest = SMALLEST if alone else SMALLEST_OF_SEVERAL
    wrong = implausible(float(extent(raw.parts).max()), frame.metres, smallest=smallest)
    if wrong or frame.metres is None:
        raise InputError(f"{mesh.file}: {wrong}")
    try:
        arranged = arranged_mesh(raw, mesh.split, mesh.drop, mesh.join)
    except InputError as error:
        raise InputError([f"{mesh.file}: {problem}" for problem in error.problems]) from None
    parts = to_world(arranged, frame.rotation, metres=frame.metres, move=frame.move)
    return parts, raw.notes, size_doubts(parts, frame.metres, mesh)


def size_doubts(parts: Iterable[RawPart], metres: float, mesh: MeshFile) -> list[Doubt]:
    """Return what is doubted of the sizes of the parts of a mesh. Numbered pieces of parts that are
    split have no names of their own.

    Parameters
    ----------
    parts, metres
        As of `implausible_sizes`.
    mesh
        What the environment says of the mesh.
    """
    known = list(parts)
    pieces = [part.name for part in known if is_piece(part.name, mesh.split)]
    return [
        Doubt(f"sizes in {mesh.file}", f"{mesh.file}: {words}")
        for words in implausible_sizes(known, metres, file=Path(mesh.file).stem, unnamed=pieces)
    ]


@dataclass(frozen=True, eq=False)
class MeshFrame:
    """How a mesh stands in the world: world = rotation @ (metres * file) + move.

    Parameters
    ----------
    metres
        Unit of the file [m], None where neither it nor the environment says it.
    rotation
        (3, 3) from the axes of the file.
    move
        (3,) [m].
    """

    metres: float | None
    rotation: Floats
    move: Floats


def mesh_frame(raw: RawMesh, mesh: MeshFile) -> MeshFrame:
    """Return how a mesh stands in the world, as an environment and the file say.

    Raises
    ------
    InputError
        If its axes are not known, or not at right angles.
    """
    metres = raw.metres if mesh.length is None else unit_metres(mesh.length)
    turn = attitude_matrix(yaw=mesh.turn.yaw, pitch=mesh.turn.pitch, roll=mesh.turn.roll)
    rotation: Floats = turn @ stated_axes(raw, mesh.up, mesh.forward)
    return MeshFrame(metres, rotation, np.array(mesh.move))


def _rule_path(file: EnvironmentFile, name: str) -> tuple[str, ...]:
    keys = [
        key
        for key in file.parts
        if file.parts[key].solid is True and name in matching_parts(key, [name])
    ]
    return ("parts", keys[-1], "solid") if keys else ("parts",)


def _rules(
    document: Document, file: EnvironmentFile, names: list[str]
) -> tuple[list[PartFile], list[str]]:
    """The rule of each part: a rule for its own name goes before any pattern, a later pattern
    before an earlier."""
    chosen = {name: PartFile() for name in names}
    faults = []
    for key in sorted(file.parts, key=lambda key: key in chosen):
        matched = matching_parts(key, names)
        if not matched:
            faults.append(
                fail(document, ("parts", key), f"no part of this name; {one_of(key, names)}")
            )
        chosen |= dict.fromkeys(matched, file.parts[key])
    return list(chosen.values()), faults


def unknown_names(document: Document, file: EnvironmentFile, names: list[str]) -> list[str]:
    """A line for each part that seats, controls, instruments and mirrors name and that is not
    there."""
    return [
        fail(document, path, f"no part {name!r}; {one_of(name, names)}")
        for path, name in _named_parts(file)
        # a cushion and a back are one part each, all else may be patterns
        if name not in names and (path[2] in ("cushion", "back") or not matching_parts(name, names))
    ]


def _named_parts(file: EnvironmentFile) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """The parts that seats, controls, instruments and mirrors name, each after where it
    stands."""
    for seat, rest in file.seats.items():
        yield ("seats", seat, "cushion", "part"), rest.cushion.part
        if rest.back.part:
            yield ("seats", seat, "back", "part"), rest.back.part
        for k, name in enumerate(rest.moves):
            yield ("seats", seat, "moves", k), name
    for control, given in file.controls.items():
        listed = not isinstance(given.part, str)
        for k, name in enumerate(given.part_keys):
            yield ("controls", control, "part", *([k] if listed else [])), name
    for section, things in (("instruments", file.instruments), ("mirrors", file.mirrors)):
        for thing, one in things.items():
            yield (section, thing, "part"), one.part


def _complete(
    document: Document,
    environment: Environment,
    file: EnvironmentFile,
    rules: list[PartFile],
    notes: list[str],
    sizes: list[Doubt],
) -> Environment:
    """The environment with its seats, points, controls, allowances, instruments and mirrors.

    rules: of each part; notes: sentences about the meshes; sizes: doubts about these.
    """
    hard = tuple(seat_of(name, seat, environment.parts) for name, seat in file.seats.items())
    furnished = replace(
        environment,
        description=file.description,
        hidden=np.array([rule.hidden for rule in rules], dtype=np.bool_),
        see_through=np.array([rule.see_through for rule in rules], dtype=np.bool_),
        seats=hard,
        points=dict(file.points),
        adjustments=adjustments_of(file, hard, environment.parts),
    )
    controlled = with_controls(furnished, file)
    allowances = (
        *_allowances(rules),
        *_resting(file, environment.parts),
        *gripped(controlled, rules),
    )
    complete = replace(
        controlled,
        allowances=allowances,
        seats=tuple(
            replace(seat, front=cushion_front(environment, seat, allowances)) for seat in hard
        ),
    )
    moved = any(any(mesh.move) for mesh in file.meshes)
    doubts = [*sizes, *environment_doubts(complete, moved=moved)]
    said = [doubt.said for doubt in open_doubts(doubts, file.accepted)]
    said += [
        f"accepted: nothing is doubted about {key!r}: leave it out; "
        f"{one_of(key, [doubt.about for doubt in doubts])}"
        for key in file.accepted
        if open_doubts(doubts, [key]) == open_doubts(doubts, [])
    ]
    faced = with_faces(complete, file, document, doubted=bool(said))
    return replace(faced, warnings=(*notes, *said, *environment.warnings))


def _allowances(rules: list[PartFile]) -> Iterator[Allowance]:
    for part, rule in enumerate(rules):
        for allow in rule.allow:
            yield Allowance(part, _segments(allow.segments), allow.depth)


def _resting(file: EnvironmentFile, parts: tuple[str, ...]) -> Iterator[Allowance]:
    """Who sits in a seat sinks in as deep as the seat says: that much contact is allowed without
    another rule."""
    for seat in file.seats.values():
        for rest in (seat.cushion, seat.back):
            if rest.part:
                depth = rest.depth + _UNEVEN
                yield Allowance(parts.index(rest.part), _segments(rest.segments), depth)


def _segments(given: str | list[str]) -> tuple[str, ...]:
    return (given,) if isinstance(given, str) else tuple(given)


def seat_of(name: str, seat: SeatFile, parts: Iterable[str]) -> Seat:
    """Return the seat that a file states; parts: those there are, for patterns of what it moves."""

    def rest(given: RestFile) -> Rest:
        return Rest(given.part, _segments(given.segments), given.depth)

    moves = tuple(dict.fromkeys(part for key in seat.moves for part in matching_parts(key, parts)))
    return Seat(
        name,
        seat.srp,
        seat.back_angle,
        seat.cushion_angle,
        seat.yaw,
        rest(seat.cushion),
        rest(seat.back),
        seat.travel.forward,
        seat.travel.up,
        moves,
    )
