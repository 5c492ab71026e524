"""The controls of `environment.yaml`: what they stand on, and how deep hands and feet may enter it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from workbench.files.environment_doubts import box_gap, part_box
from workbench.files.environment_own import GRIPPABLE, Handle, own_pieces
from workbench.files.environment_parts import matching_parts
from workbench.files.environment_schema import ControlFile, EnvironmentFile, PartFile
from workbench.model.environment import Allowance, Control, Environment, OwnPiece

__all__ = ["gripped", "with_controls"]

_GRIPPED = {"push": 0.015, "pinch": 0.015, "grasp": 0.03, "foot": 0.025}
"""How deep [m] the sphere hand or foot may be in what it grips, without another rule: flesh gives
way, and the bent fingers of a fist are not in the body's hand. Assumed by this project: a grasp
takes up the thickness of a palm, a pinch or a push that of a finger, a foot that of a sole."""
_GRIPPERS = {"hand": ("LHN", "RHN"), "foot": ("LF", "RF")}


def with_controls(environment: Environment, file: EnvironmentFile) -> Environment:
    """Return an environment, complete but for its controls, with those of its file.

    A list of parts, or a pattern, says what is a control's own. Of a control with the name of one
    part the other pieces are looked for; `assumed` tells which were taken along.
    """
    stated = [_control(environment, name, given) for name, given in file.controls.items()]
    open_ones = {
        control.name
        for control, given in zip(stated, file.controls.values(), strict=True)
        if given.part == control.part
    }
    handles = _handles(environment, stated, open_ones)
    seats = environment.seats
    rests = {rest.part for seat in seats for rest in (seat.cushion, seat.back)}
    found = own_pieces(environment, handles, rests)
    pieces = {
        name: more
        for handle, more in zip(handles, found.pieces, strict=True)
        for name in handle.controls
        if not handle.stated
    }
    controls = tuple(
        replace(control, pieces=pieces.get(control.name, control.pieces)) for control in stated
    )
    told = (*_taken_along(environment, handles, found.pieces), *found.claimed)
    return replace(environment, controls=controls, assumed=(*environment.assumed, *told))


def _control(environment: Environment, name: str, given: ControlFile) -> Control:
    """A control with the parts that its file names."""
    keys = given.part_keys
    parts = [part for key in keys for part in matching_parts(key, environment.parts)]
    main = ""
    if parts:
        first = matching_parts(keys[0], environment.parts)
        main = min(first, key=lambda part: (box_gap(part_box(environment, part), given.at), part))
    others = tuple(OwnPiece(part) for part in dict.fromkeys(parts) if part != main)
    return Control(name, given.at, given.grip, given.zone, main, others)


def _handles(
    environment: Environment, controls: Sequence[Control], open_ones: set[str]
) -> list[Handle]:
    """What the controls stand on: those that name one part and no more, together where it is the
    same."""
    found: list[Handle] = []
    on: dict[str, list[str]] = {}
    for control in controls:
        if control.name in open_ones and control.part:
            on.setdefault(control.part, []).append(control.name)
        elif control.part:
            parts = tuple(environment.part(part) for part in control.own_parts)
            found.append(Handle(parts, (control.name,), stated=True))
    for part, names in on.items():
        found.append(Handle((environment.part(part),), tuple(names), stated=False))
    return found


def _taken_along(
    environment: Environment,
    handles: Sequence[Handle],
    pieces: Sequence[Sequence[OwnPiece]],
) -> Iterator[str]:
    """A sentence for each piece that was taken along."""
    for handle, more in zip(handles, pieces, strict=True):
        whose = f"control{'s' if len(handle.controls) > 1 else ''} " + ", ".join(
            repr(name) for name in handle.controls
        )
        own = environment.parts[handle.parts[0]]
        for piece in more:
            yield f"{whose}: {piece.part!r} counts as a piece of {own!r}: {piece.why}"


def gripped(environment: Environment, rules: Sequence[PartFile]) -> Iterator[Allowance]:
    """Yield how deep who uses a control may be in its own parts: by what the grip does, where the
    part has no rule for hands or feet.

    rules: of each part.
    """
    for control in environment.controls:
        segments = _GRIPPERS["foot" if control.for_feet else "hand"]
        for name in control.own_parts:
            part = environment.part(name)
            ruled = {segment for allow in rules[part].allow for segment in allow.segments}
            whole = any(allow.segments == "all" for allow in rules[part].allow)
            small = np.ptp(part_box(environment, name), axis=0).max() <= GRIPPABLE
            if small and not (whole or ruled.intersection(segments)):
                yield Allowance(part, segments, _GRIPPED[control.grip])
