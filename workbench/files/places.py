"""Where somebody is put: the position of a seat, a segment at a place, feet on a point."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field

from workbench.files.postures import AttitudeFile
from workbench.files.schema import FileModel, Length, Vector

__all__ = ["AdjustFile", "AreaFile", "AtFile", "StandFile"]

WIDEST = 2.0
"""Width [m] of an area to step in, at most: the search of a position goes all over it."""


class AdjustFile(FileModel):
    """Where in its travel a seat stands."""

    forward: Length = 0.0
    up: Length = 0.0


class AtFile(FileModel):
    """A segment at a place."""

    segment: str
    position: Vector
    attitude: AttitudeFile = AttitudeFile()


def _rising(value: tuple[float, float]) -> tuple[float, float]:
    low, high = value
    if not low <= 0.0 <= high:
        raise ValueError(
            "it is from how far behind or to the right, 0 or negative, to how far "
            "ahead or to the left, 0 or positive: [-200, 300]"
        )
    if high - low > WIDEST:
        raise ValueError(f"an area is {WIDEST:g} m wide at most")
    return value


Steps = Annotated[tuple[Length, Length], Field(strict=False), AfterValidator(_rising)]


class AreaFile(FileModel):
    """The area within which the feet may be: how far from the point they may step, as the person
    faces, forward and to the left; negative to the rear and to the right."""

    forward: Steps = (0.0, 0.0)
    left: Steps = (0.0, 0.0)


class StandFile(FileModel):
    """A point that the lowest sphere stands on, the heading, and how far the person may step."""

    on: Vector
    yaw: Annotated[float, Field(ge=-360, le=360)] = 0.0
    area: AreaFile | None = None
