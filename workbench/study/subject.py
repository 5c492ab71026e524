"""The body of a recorded subject: the study's body with the lengths that the motion file itself
says."""

from __future__ import annotations

from pathlib import Path

from workbench.body.scaling.morph import lengthened
from workbench.errors import InputError
from workbench.files.motions.reading import read_motion
from workbench.model.body import Body
from workbench.model.motion import Bones, Markers, SegmentTrack
from workbench.motion.recorded.subject import (
    factors_from_bones,
    factors_from_markers,
    factors_from_track,
)
from workbench.study.motions import MotionOptions

__all__ = ["subject_body"]

_TOLD = 0.005


def subject_body(
    body: Body, path: str | Path, *, options: MotionOptions | None = None
) -> tuple[Body, tuple[str, ...]]:
    """The body with its limbs and trunk as long as the file says, and what was changed by how
    much, in sentences.

    BVH: the bones at rest (the unit must be stated: the unit that is guessed makes the legs as long
    as the body's). Markers: medians of distances that hardly depend on the pose. Single segments:
    the joints about which they turn. What the file does not say stays as it is. InputError where
    it states no length.
    """
    given = options or MotionOptions()
    found = next(
        read_motion(
            path, body, up=given.up, metres=given.metres, names=given.names, keep=given.keep
        )
    )
    factors: dict[str, float] = {}
    if isinstance(found, Bones):
        if given.metres is None:
            raise InputError(
                f"{path}: a body scaled to the subject needs the file's unit of length: state it (unit: 1 cm in a study, --unit '1 cm')"
            )
        factors = factors_from_bones(body, found, given.names, given.metres)
    elif isinstance(found, Markers):
        factors = factors_from_markers(body, found, given.names)
    elif isinstance(found, SegmentTrack):
        factors = factors_from_track(body, found)
    if not factors:
        raise InputError(
            f"{path}: states no length of the subject's limbs: bones do, markers at knees and ankles or at "
            "elbows and wrists, or segments that turn against each other"
        )
    try:
        made = lengthened(body, factors)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return made, tuple(_changes(body, made, factors, Path(path).name))


def _changes(body: Body, made: Body, factors: dict[str, float], file: str) -> list[str]:
    """One sentence: each pair of twins once."""
    parts: dict[str, float] = {}
    for segment, factor in factors.items():
        name = body.segment_names[body.segment(segment)]
        twin = name.removeprefix("left ").removeprefix("right ")
        same = [k for k in factors if body.segment_names[body.segment(k)].endswith(twin)]
        alike = len(same) == 2 and abs(factors[same[0]] - factors[same[1]]) < _TOLD
        parts[f"{twin}s" if alike else name] = factor
    said = ", ".join(f"{name} {100 * (f - 1):+.0f} %" for name, f in parts.items())
    tall = f"{1000 * _stature(body):.0f} mm tall before, {1000 * _stature(made):.0f} mm now"
    return [f"{file}: the lengths of {body.name} are scaled to the subject: {said}; {tall}"]


def _stature(body: Body) -> float:
    """[m] from the soles to the top in the zero pose."""
    z = body.zero_origins[0, body.sphere_segment, 2] + body.centre[0, :, 2]
    return float((z + body.radius[0]).max() - (z - body.radius[0]).min())
