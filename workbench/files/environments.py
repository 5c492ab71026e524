"""Environments from `environment.yaml` and its meshes, or from one bare mesh."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.catalogue import find, is_folder
from workbench.files.environment_controls import gripped, with_controls
from workbench.files.environment_doubts import environment_doubts
from workbench.files.environment_faces import with_faces
from workbench.files.environment_parts import arranged_mesh, is_piece, matching_parts
from workbench.files.environment_schema import (
    AdjustmentFile,
    EnvironmentFile,
    MeshFile,
    PartFile,
    RestFile,
    SeatFile,
    unit_metres,
)
from workbench.files.meshes.assembly import build_environment
from workbench.files.meshes.frame_doubts import PlacedMesh, frame_doubts
from workbench.files.meshes.obj import outside_folder
from workbench.files.meshes.parts import RawMesh, RawPart
from workbench.files.meshes.reading import (
    SMALLEST,
    SMALLEST_OF_SEVERAL,
    axes_rotation,
    extent,
    implausible,
    outsized_words,
    read_mesh,
    stated_axes,
    to_world,
)
from workbench.files.meshes.scene import mesh_of_scene
from workbench.files.meshes.sizes import implausible_sizes
from workbench.files.schema import error_at, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.arrays import Floats
from workbench.model.environment import (
    Adjustment,
    Allowance,
    CushionFront,
    Doubt,
    Environment,
    Rest,
    Seat,
    open_doubts,
)
from workbench.model.joint_angles import attitude_matrix
from workbench.model.surroundings import seat_tilt

__all__ = [
    "MOST_ADJUSTMENTS",
    "MeshFrame",
    "adjustment_faults",
    "adjustments_of",
    "bare_environment",
    "cushion_front",
    "environment_files",
    "environment_from_mesh",
    "load_environment",
    "mesh_frame",
    "part_rules",
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
    try:
        file = validate(document, EnvironmentFile)
    except InputError as error:
        raise InputError([*error.problems, *_faults_of_names(document, path.parent)]) from None
    parts, notes, sizes = _meshes(document, file, path.parent)
    names = [part.name for part in parts]
    rules = part_rules(file, names)
    faults = unknown_names(document, names)
    faults += adjustment_faults(document, file, names)
    environment, open_parts = build_environment(
        file.environment, parts, solid=[rule.solid for rule in rules]
    )
    faults += [error_at(document, _rule_path(file, names[k]), what) for k, what in open_parts]
    if faults:
        raise InputError(faults)
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
    doubted: list[str] = []
    faults: list[str] = []
    meshes: list[PlacedMesh] = []
    for row, mesh in enumerate(file.meshes):
        key = ("meshes", row, "file")
        try:
            stands, said, odd = _mesh(folder, mesh, alone=len(file.meshes) == 1)
        except InputError as error:
            faults += [error_at(document, key, problem) for problem in error.problems]
            continue
        meshes.append(stands)
        taken = {part.name for part in parts}
        twice = [part.name for part in stands.parts if part.name in taken]
        faults += [error_at(document, key, _twice(file, row, name)) for name in twice]
        parts += stands.parts
        notes += [f"{mesh.file}: {note}" for note in said]
        doubts += odd
        doubted += [mesh.file] if odd else []
    if not faults and (wrong := implausible(float(extent(tuple(parts)).max()), 1.0)):
        faults.append(error_at(document, ("meshes",), wrong))
    if faults:
        raise InputError(faults)
    return parts, notes, [*doubts, *frame_doubts(meshes, doubted=doubted)]


def _twice(file: EnvironmentFile, row: int, name: str) -> str:
    """That a part of a mesh is in another one too, and what helps."""
    new = f"{Path(file.meshes[row].file).stem}_{name}"
    return (
        f"part {name!r} is in another mesh too: give this one another name, "
        f"join: {{{new}: [{name}]}}"
    )


def _mesh(
    folder: Path, mesh: MeshFile, *, alone: bool
) -> tuple[PlacedMesh, tuple[str, ...], list[Doubt]]:
    """A mesh in the world, notes about it, and doubts about its sizes. alone:
    it is all there is."""
    if outside_folder(mesh.file):
        raise InputError(
            f"{mesh.file}: a mesh lies in the folder of its environment file, or below it"
        )
    raw = read_mesh(folder / mesh.file)
    frame = mesh_frame(raw, mesh)
    try:
        arranged = arranged_mesh(raw, mesh.split, mesh.drop, mesh.join)
    except InputError as error:
        raise InputError([f"{mesh.file}: {problem}" for problem in error.problems]) from None
    smallest = SMALLEST if alone else SMALLEST_OF_SEVERAL
    wrong = implausible(float(extent(arranged.parts).max()), frame.metres, smallest=smallest)
    if wrong or frame.metres is None:
        aside = outsized_words(arranged.parts)
        raise InputError("; ".join(filter(None, (f"{mesh.file}: {wrong}", aside))))
    parts = to_world(arranged, frame.rotation, metres=frame.metres, move=frame.move)
    stands = PlacedMesh(mesh.file, parts, frame.metres, frame.rotation, frame.move)
    return stands, raw.notes, size_doubts(parts, frame.metres, mesh)


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


def part_rules(file: EnvironmentFile, names: Sequence[str]) -> list[PartFile]:
    """The rule of each part: a rule for its own name goes before any pattern, a later pattern
    before an earlier."""
    chosen = {name: PartFile() for name in names}
    for key in sorted(file.parts, key=lambda key: key in chosen):
        chosen |= dict.fromkeys(matching_parts(key, names), file.parts[key])
    return list(chosen.values())


_PART_KEYS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("seats", ("cushion", "part")),
    ("seats", ("back", "part")),
    ("seats", ("moves",)),
    ("controls", ("part",)),
    ("adjustments", ("parts",)),
    ("instruments", ("part",)),
    ("mirrors", ("part",)),
)
"""Sections of an environment's file, and the keys of their things that name parts."""


def unknown_names(document: Document, names: Sequence[str]) -> list[str]:
    """Return a line for each part that the file has rules for, or that its things name, and that is
    not there. What is no name at all is passed over.

    Parameters
    ----------
    document
        The file, which need not be valid.
    names
        The parts of its meshes.
    """
    return [
        error_at(document, path, f"no part {name!r}; {one_of(name, names)}")
        for path, name in _named_parts(document.value)
        # a cushion and a back are one part each, all else may be patterns
        if name not in names
        and (path[2:3] in (("cushion",), ("back",)) or not matching_parts(name, names))
    ]


def _named_parts(says: Mapping[str, Any]) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """The parts that a file names, each after where it stands."""
    for key in _mapping(says.get("parts")):
        yield ("parts", key), key
    for section, keys in _PART_KEYS:
        for thing, one in _mapping(says.get(section)).items():
            for key in keys:
                one = _mapping(one).get(key)
            for k, name in enumerate(one if isinstance(one, list) else [one]):
                if isinstance(name, str) and name:
                    yield (section, thing, *keys, *([k] if isinstance(one, list) else [])), name


def _mapping(value: Any) -> Mapping[str, Any]:
    """A value that is a mapping; an empty one for another."""
    return value if isinstance(value, dict) else {}


def _faults_of_names(document: Document, folder: Path) -> list[str]:
    """What is wrong with the meshes and the names of parts of a file that has other faults too; []
    where these faults are of its meshes or its unit."""
    says = _mapping(document.value)
    own = {key: says[key] for key in ("length", "meshes") if key in says}
    try:
        file = validate(replace(document, value={"environment": "_", **own}), EnvironmentFile)
    except InputError:
        return []
    try:
        parts, _, _ = _meshes(document, file, folder)
    except InputError as error:
        return list(error.problems)
    return unknown_names(document, [part.name for part in parts])


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


# The front of a cushion, as thighs lie on it: a section of its part, from half its length to its
# front edge.

_THIGHS = {"LUL", "RUL", "all"}
_ASIDE = 0.1
"""How far [m] beside the middle of the seat the section is taken, on both sides: under the thighs,
inside of side bolsters."""
_FROM = 0.5
"""Where the front begins, as a share of the cushion's length."""
_FLAT = 1e-9


def cushion_front(
    environment: Environment, seat: Seat, allowances: Iterable[Allowance]
) -> CushionFront | None:
    """Return what thighs rest on in a seat: the convex upper side of the front of its cushion.

    It gives as much as the cushion's part allows thighs to enter, and at least as much as hips sink
    into it. None where the part does not reach under the thighs.

    Parameters
    ----------
    environment
        The parts.
    seat
        The seat where it stands at rest.
    allowances
        What is allowed to enter parts.
    """
    points = _section(environment, seat)
    length = points[..., 0].max(initial=0.0)
    chain = _upper_chain(_beyond(points, _FROM * length))
    if len(chain) < 2:
        return None
    along, above = (chain[1:] - chain[:-1]).T
    normal = np.stack([-above, along], axis=1)
    normal = normal[along > _FLAT] / np.hypot(along, above)[along > _FLAT, None]
    offset = np.sum(normal * chain[:-1][along > _FLAT], axis=1)
    faces = [*np.column_stack([normal, offset]).tolist(), [1.0, 0.0, float(length)]]
    part = environment.part_index(seat.cushion.part)
    allowed = [a.depth for a in allowances if a.part == part and _THIGHS & set(a.segments)]
    gives = max([seat.cushion.depth, *allowed])
    return CushionFront(tuple((a, b, c) for a, b, c in faces), gives)


def _section(environment: Environment, seat: Seat) -> Floats:
    """(L, 2, 2) [m] lines in which upright planes under the thighs cut the cushion: end, along and
    above from the seat reference point."""
    heading = attitude_matrix(yaw=seat.yaw)
    c = np.cos(seat.cushion_angle)
    s = np.sin(seat.cushion_angle)
    axes = heading @ np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    part = environment.part_index(seat.cushion.part)
    corners = (environment.triangle_corners(part) - np.array(seat.srp)) @ axes
    lines = []
    for aside in (-_ASIDE, _ASIDE):
        side = corners[..., 1] - aside
        cut = (side < 0.0) != (np.roll(side, -1, axis=1) < 0.0)
        crossing = cut.any(axis=1)
        share = side[crossing] / np.where(
            cut[crossing], side[crossing] - np.roll(side[crossing], -1, axis=1), 1.0
        )
        first = corners[crossing]
        met = first + share[..., None] * (np.roll(first, -1, axis=1) - first)
        lines.append(met[cut[crossing]].reshape(-1, 2, 3)[..., [0, 2]])
    return np.concatenate(lines)


def _beyond(lines: Floats, least: float) -> Floats:
    """(P, 2) ends of lines (L, 2, 2), of which all before `least` along is cut off."""
    kept = lines[lines[..., 0].max(axis=1) > least]
    way = kept[:, ::-1] - kept
    short = kept[..., 0] < least
    share = np.where(short, (least - kept[..., 0]) / np.where(short, way[..., 0], 1.0), 0.0)
    met: Floats = kept + share[..., None] * way
    return met.reshape(-1, 2)


def _upper_chain(points: Floats) -> Floats:
    """(C, 2) the upper side of the convex hull of points, from rear to front (Andrew's monotone
    chain)."""
    chain: list[Floats] = []
    for point in points[np.lexsort((points[:, 1], points[:, 0]))]:
        while len(chain) > 1 and _left_turn(chain[-2], chain[-1], point):
            chain.pop()
        chain.append(point)
    return np.array(chain).reshape(-1, 2)


def _left_turn(a: Floats, b: Floats, c: Floats) -> bool:
    """Whether the way over three points turns left, or goes straight on."""
    ahead = b - a
    beyond = c - b
    return bool(ahead[0] * beyond[1] - ahead[1] * beyond[0] >= -_FLAT * _FLAT)


MOST_ADJUSTMENTS = 4
"""Adjustments that the occupant of one seat may make, its tilt with them: settings are tried in
combination, and four have 81 with three settings each."""
Key = tuple[str | int, ...]


def adjustment_faults(document: Document, file: EnvironmentFile, names: Sequence[str]) -> list[str]:
    """A line for each thing that is wrong with the adjustments of a file.

    names: the parts of the meshes.
    """
    every = (
        *_unknown(file),
        *_mounted_on_themselves(file),
        *_without_parts(file),
        *_moved_twice(file, names),
        *_tilts_named(file),
        *_too_many(file),
    )
    return [error_at(document, key, what) for key, what in every]


def _unknown(file: EnvironmentFile) -> Iterator[tuple[Key, str]]:
    """Points, seats and adjustments that are named and not there."""
    for name, one in file.adjustments.items():
        for k, point in enumerate(one.points):
            if point not in file.points:
                key: Key = ("adjustments", name, "points", k)
                yield key, f"no point {point!r}; {one_of(point, file.points)}"
        for what, given, valid in (
            ("adjustment", one.mounted_on, file.adjustments),
            ("seat", one.seat, file.seats),
        ):
            if given is not None and given not in valid:
                key = ("adjustments", name, "seat" if what == "seat" else "mounted_on")
                yield key, f"no {what} {given!r}; {one_of(given, valid)}"


def _mounted_on_themselves(file: EnvironmentFile) -> Iterator[tuple[Key, str]]:
    """Adjustments that carry themselves."""
    for name, one in file.adjustments.items():
        seen = {name}
        carrier = one.mounted_on
        while carrier is not None and carrier in file.adjustments and carrier not in seen:
            seen.add(carrier)
            carrier = file.adjustments[carrier].mounted_on
        if carrier == name:
            what = "it is mounted on itself; name the adjustment that carries it, or leave it out"
            yield ("adjustments", name, "mounted_on"), what


def _without_parts(file: EnvironmentFile) -> Iterator[tuple[Key, str]]:
    """Adjustments that move nothing."""
    carriers = {one.mounted_on for one in file.adjustments.values()}
    for name, one in file.adjustments.items():
        if not (one.parts or one.points or name in carriers):
            yield ("adjustments", name), "it moves nothing: name the 'parts' that it moves"


def _moved_twice(file: EnvironmentFile, names: Sequence[str]) -> Iterator[tuple[Key, str]]:
    """Parts and points that something else moves already."""
    movers: dict[str, str] = {}
    for seat, stated in file.seats.items():
        for key in (stated.cushion.part, stated.back.part, *stated.moves):
            movers |= dict.fromkeys(matching_parts(key, names), f"seat {seat!r}")
    placers: dict[str, str] = {}
    for name, one in file.adjustments.items():
        advice = "; list it once, and say 'mounted_on' where one adjustment carries another"
        for k, key in enumerate(one.parts):
            for part in matching_parts(key, names):
                other = movers.setdefault(part, f"adjustment {name!r}")
                if other != f"adjustment {name!r}":
                    what = f"part {part!r} is moved by {other} already{advice}"
                    yield ("adjustments", name, "parts", k), what
        for k, point in enumerate(one.points):
            other = placers.setdefault(point, f"adjustment {name!r}")
            if other != f"adjustment {name!r}":
                what = f"point {point!r} is moved by {other} already{advice}"
                yield ("adjustments", name, "points", k), what


def _tilts_named(file: EnvironmentFile) -> Iterator[tuple[Key, str]]:
    """Adjustments with the name that the tilt of a seat has."""
    tilts = {f"{seat}_tilt": seat for seat, stated in file.seats.items() if any(stated.travel.tilt)}
    for name in file.adjustments:
        if name in tilts:
            what = f"the tilt of seat {tilts[name]!r} has this name; take another"
            yield ("adjustments", name), what


def _too_many(file: EnvironmentFile) -> Iterator[tuple[Key, str]]:
    """More adjustments than are tried in combination."""
    for seat, stated in file.seats.items():
        own = [name for name, one in file.adjustments.items() if one.seat in (None, seat)]
        count = len(own) + any(stated.travel.tilt)
        if count > MOST_ADJUSTMENTS:
            what = (
                f"the occupant of seat {seat!r} has {count} adjustments, and their settings are "
                f"tried in combination; {MOST_ADJUSTMENTS} are possible, the seat's tilt with them "
                f"('seat' says whose an adjustment is)"
            )
            yield ("adjustments",), what
            return


def adjustments_of(
    file: EnvironmentFile, seats: Sequence[Seat], names: Sequence[str]
) -> tuple[Adjustment, ...]:
    """The adjustments of a file without faults, then the tilts of its seats.

    names: the parts of the meshes.
    """
    stated = [_adjustment(name, one, names) for name, one in file.adjustments.items()]
    tilts = [
        seat_tilt(seat, file.seats[seat.name].travel.tilt)
        for seat in seats
        if any(file.seats[seat.name].travel.tilt)
    ]
    return (*stated, *tilts)


def _adjustment(name: str, file: AdjustmentFile, names: Sequence[str]) -> Adjustment:
    axis = file.along if file.about is None else file.about.axis
    assert axis is not None
    return Adjustment(
        name=name,
        axis=axis,
        pivot=None if file.about is None else file.about.point,
        travel=file.travel,
        parts=tuple(dict.fromkeys(p for key in file.parts for p in matching_parts(key, names))),
        points=tuple(dict.fromkeys(file.points)),
        mounted_on=file.mounted_on or "",
        seat=file.seat or "",
    )
