"""Where somebody is put: the position of a seat, a segment at a place, feet on a point."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from workbench.files.postures import AttitudeFile
from workbench.files.schema import FileModel, Length, Vector

__all__ = ["AdjustFile", "AtFile", "StandFile"]


class AdjustFile(FileModel):
    """Where in its travel a seat stands."""

    forward: Length = 0.0
    up: Length = 0.0


class AtFile(FileModel):
    """A segment at a place."""

    segment: str
    position: Vector
    attitude: AttitudeFile = AttitudeFile()


class StandFile(FileModel):
    """A point that the lowest sphere stands on, and the heading."""

    on: Vector
    yaw: Annotated[float, Field(ge=-360, le=360)] = 0.0
