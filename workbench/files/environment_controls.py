"""The controls of `environment.yaml`: what they stand on, and how deep hands and feet may enter it."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from workbench.files.environment_doubts import box_gap, near_part
from workbench.files.environment_own import (
    Handle,
    NearbyParts,
    PartMeshes,
    Touching,
    grippable,
    own_pieces,
    part_meshes,
)
from workbench.files.environment_parts import matching_parts
from workbench.files.environment_schema import ControlFile, EnvironmentFile, PartFile
from workbench.model.environment import Allowance, Control, Environment, OwnPiece

__all__ = ["FoundControls", "found_controls", "gripped", "with_controls"]

_GRIPPED = {"push": 0.015, "pinch": 0.015, "grasp": 0.03, "foot": 0.025}
"""How deep [m] the sphere hand or foot may be in what it grips, without another rule: flesh gives
way, and the bent fingers of a fist are not in the body's hand. Assumed by this project: a grasp
takes up the thickness of a palm, a pinch or a push that of a finger, a foot that of a sole."""
_MOST_TOLD = 4
"""Pieces of one control that have a sentence each."""
_GRIPPERS = {"hand": ("LHN", "RHN"), "foot": ("LF", "RF")}


@dataclass(frozen=True)
class FoundControls:
    """The controls of a file with their parts, and sentences about what it leaves open."""

    controls: tuple[Control, ...]
    assumed: tuple[str, ...]


def with_controls(environment: Environment, file: EnvironmentFile) -> Environment:
    """Return an environment, complete but for its controls, with those of its file."""
    hidden = [name for k, name in enumerate(environment.parts) if environment.hidden[k]]
    found = found_controls(file, Touching(part_meshes(environment)), hidden)
    assumed = (*_partless(environment, found.controls), *found.assumed)
    return replace(environment, controls=found.controls, assumed=assumed)


def _partless(environment: Environment, controls: Iterable[Control]) -> Iterator[str]:
    """A sentence for all controls that name no part, with the part that each is next to."""
    shown = [name for k, name in enumerate(environment.parts) if not environment.hidden[k]]
    bare = {one.name: near_part(environment, one.at, shown) for one in controls if not one.part}
    told = [
        f"{name!r}" + (f" ({1e3 * near.gap:.0f} mm from {near.name!r})" if near else "")
        for name, near in bare.items()
    ]
    if told:
        yield (
            f"control{'s' * (len(told) > 1)} {', '.join(told)}: no part is named; a control without "
            f"one goes along with nothing, and nothing may be entered to use it"
        )


def found_controls(
    file: EnvironmentFile, touching: Touching, hidden: Iterable[str]
) -> FoundControls:
    """Find the parts of the controls of a file.

    A list of parts, or a pattern, says what is a control's own. Of a control with the name of one
    part the other pieces are looked for.

    Parameters
    ----------
    file
        Without faults: all that it names is there.
    touching
        The parts.
    hidden
        Those that are neither drawn nor checked.
    """
    meshes = touching.meshes
    stated = [_control(meshes, name, given) for name, given in file.controls.items()]
    open_ones = {
        control.name
        for control, given in zip(stated, file.controls.values(), strict=True)
        if given.part == control.part
    }
    handles = _handles(meshes.names, stated, open_ones)
    found = own_pieces(touching, handles, _surroundings(file, meshes.names, hidden))
    pieces = {
        name: more
        for handle, more in zip(handles, found.pieces, strict=True)
        for name in handle.controls
        if not handle.stated
    }
    controls = tuple(
        replace(control, pieces=pieces.get(control.name, control.pieces)) for control in stated
    )
    told = _taken_along(meshes.names, handles, found.pieces)
    return FoundControls(controls, (*told, *found.claimed))


def _surroundings(
    file: EnvironmentFile, names: Sequence[str], hidden: Iterable[str]
) -> NearbyParts:
    """What of the parts bears on pieces: what is hidden, what is sat on and what is moved."""

    def meant(keys: Iterable[str]) -> tuple[str, ...]:
        return tuple(dict.fromkeys(part for key in keys for part in matching_parts(key, names)))

    seats = file.seats.items()
    rests = {rest.part for _, seat in seats for rest in (seat.cushion, seat.back)}
    movers = {f"seat {name}": meant(seat.moves) for name, seat in seats}
    movers |= {f"adjustment {name}": meant(one.parts) for name, one in file.adjustments.items()}
    return NearbyParts(frozenset(hidden), frozenset(rests), movers)


def _control(meshes: PartMeshes, name: str, given: ControlFile) -> Control:
    """A control with the parts that its file names."""
    keys = given.part_keys
    parts = [part for key in keys for part in matching_parts(key, meshes.names)]
    main = ""
    if parts:

        def away(part: str) -> tuple[float, str]:
            return box_gap(meshes.boxes[meshes.names.index(part)], given.at), part

        main = min(matching_parts(keys[0], meshes.names), key=away)
    others = tuple(OwnPiece(part) for part in dict.fromkeys(parts) if part != main)
    return Control(name, given.at, given.grip, given.zone, main, others)


def _handles(
    names: Sequence[str], controls: Sequence[Control], open_ones: Container[str]
) -> list[Handle]:
    """What the controls stand on: those that name one part and no more, together where it is the
    same."""
    found: list[Handle] = []
    on: dict[str, list[str]] = {}
    for control in controls:
        if control.name in open_ones and control.part:
            on.setdefault(control.part, []).append(control.name)
        elif control.part:
            parts = tuple(names.index(part) for part in control.own_parts)
            found.append(Handle(parts, (control.name,), stated=True))
    for part, those in on.items():
        found.append(Handle((names.index(part),), tuple(those), stated=False))
    return found


def _taken_along(
    names: Sequence[str], handles: Sequence[Handle], pieces: Sequence[Sequence[OwnPiece]]
) -> Iterator[str]:
    """A sentence for each piece that was taken along, or for all of a control that has many."""
    for handle, more in zip(handles, pieces, strict=True):
        whose = f"control{'s' if len(handle.controls) > 1 else ''} " + ", ".join(
            repr(name) for name in handle.controls
        )
        own = names[handle.parts[0]]
        if len(more) > _MOST_TOLD:
            listed = ", ".join(piece.part for piece in more)
            why = "; ".join(dict.fromkeys(piece.why for piece in more))
            yield (
                f"{whose}: {len(more)} parts count as pieces of {own!r} ({listed}): each touches "
                f"it or another one, and {why}"
            )
            continue
        for piece in more:
            yield (
                f"{whose}: {piece.part!r} counts as a piece of {own!r}: it touches "
                f"{piece.beside}, and {piece.why}"
            )


def gripped(environment: Environment, rules: Sequence[PartFile]) -> Iterator[Allowance]:
    """Yield how deep who uses a control may be in its own parts: by what the grip does, where the
    part has no rule for hands or feet.

    rules: of each part.
    """
    for control in environment.controls:
        segments = _GRIPPERS["foot" if control.for_feet else "hand"]
        for name in control.own_parts:
            part = environment.part_index(name)
            ruled = {segment for allow in rules[part].allow for segment in allow.segments}
            whole = any(allow.segments == "all" for allow in rules[part].allow)
            small = grippable(environment.triangle_corners(part))
            if small and not (whole or ruled.intersection(segments)):
                yield Allowance(part, segments, _GRIPPED[control.grip])
