"""A study of people in postures: who is where in which environment, in which cases, and what must
hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.driving import DrivingAims
from workbench.model.encumbrance import Encumbrance
from workbench.model.environment import Environment
from workbench.model.growth import Growth
from workbench.model.population import PopulationModel
from workbench.model.poses import Poses

__all__ = ["Aims", "Person", "PostureStudy", "ReachTask", "SeatFit", "Size"]


@dataclass(frozen=True)
class Aims:
    """What a sitter's posture is predicted from: by limb ("left hand", ...) the control that it
    holds; the point whose height the eyes are to reach and the point on the floor whose height the
    heels stand at, None where any. driving: of a driver at the wheel, whose posture is the
    statistical one."""

    controls: Mapping[str, str]
    eyes: str | None = None
    heels: str | None = None
    driving: DrivingAims | None = None


@dataclass(frozen=True)
class ReachTask:
    """Reach envelopes that a study asks for: whose, by which hand, grip and zone, whether obstacles
    are heeded, and the index of the case whose posture it begins from."""

    person: str
    limb: str
    grip: str
    zone: int
    obstacles: bool
    case: int = 0


@dataclass(frozen=True, eq=False)
class Size:
    """A person's measures [m; mass in kg], and the population whose people the other measures are
    taken from, or the growth charts and the age [years] of a child."""

    sex: str
    measures: Mapping[str, float]
    population: PopulationModel | Growth
    age: float | None = None


@dataclass(frozen=True)
class SeatFit:
    """How the seat and the pedals came out for a predicted sitter.

    miss [m]: how far the worse `foot` stays from its pedal, and what limits it in words; foot is ""
    where neither foot has a pedal. spare [m]: travel of the seat that is left to its nearer end,
    fore and aft, at the position wanted; negative where that is beyond the travel.
    """

    miss: float
    foot: str
    limit: str
    spare: float


@dataclass(frozen=True, eq=False)
class Person:
    """One body in all cases of a study: P poses, one a case.

    seat: the seat it is put into (its adjustment `forward` and `up` [m]); or `stand`: a point (3,)
    [m] that the lowest sphere stands on; or neither, where the poses are placed already. size: the
    measures the body is scaled to when the study runs, None for the body as it is. detail: the
    level of detail of its family, its own where None; wears: what it is dressed in then. aims: by
    case, what the posture is predicted from, None where it is given; free_seat: the seat goes where
    the first predicted case wants it. held: by case, True where the poses say where the sitter is
    and the seat's planes do not: a driver sits by the hip point. fits: by case, how seat and pedals
    came out, None where the posture is given; () before postures are predicted.
    """

    name: str
    body: Body
    poses: Poses
    postures: tuple[str, ...]
    seat: str | None = None
    forward: float = 0.0
    up: float = 0.0
    stand: tuple[float, float, float] | None = None
    size: Size | None = None
    detail: str | None = None
    wears: tuple[Encumbrance, ...] = ()
    aims: tuple[Aims | None, ...] = ()
    free_seat: bool = False
    held: tuple[bool, ...] = ()
    fits: tuple[SeatFit | None, ...] = ()


@dataclass(frozen=True, eq=False)
class PostureStudy:
    """People who are present at once, each in one posture a case. `inputs` are the files it was
    read from, by role; `envelopes` the reach envelopes asked for."""

    name: str
    title: str
    description: str
    environment: Environment
    people: tuple[Person, ...]
    cases: tuple[str, ...]
    criteria: tuple[Criterion, ...]
    inputs: Mapping[str, Path]
    warnings: tuple[str, ...] = ()
    envelopes: tuple[ReachTask, ...] = ()
