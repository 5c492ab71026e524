"""Study: who is where in which environment, in which cases, and what must hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from pathlib import Path

from workbench.model.body import Body
from workbench.model.driving import DrivingAims
from workbench.model.encumbrance import Encumbrance
from workbench.model.environment import Environment
from workbench.model.growth import Growth
from workbench.model.population import PopulationModel
from workbench.model.poses import Poses

__all__ = ["Aims", "Criterion", "Person", "ReachTask", "Size", "Study"]


@dataclass(frozen=True)
class Criterion:
    """Something that must hold in every case, or for everybody.

    check: contact, clearance, self_contact, between_people, stops or reach; of accommodation also
    vision and seat. people, segments, parts, controls: those it is about. at_least: [m] for
    clearance and between_people, [rad] for stops. zone: the harness zone in which controls are to
    be reached, each control's own where None.

    Of accommodation: hand: that must reach ("left", "right"), either where None; subparts: named
    spheres ("RLL/knee cap") instead of whole segments; below, above: how far [m] the eyes may be
    below and above their point, infinite where either may be any; of a vision over parts, at_least
    is the angle down [rad].
    """

    name: str
    check: str
    people: tuple[str, ...]
    segments: tuple[str, ...]
    parts: tuple[str, ...]
    at_least: float
    controls: tuple[str, ...] = ()
    zone: int | None = None
    hand: str | None = None
    subparts: tuple[str, ...] = ()
    below: float = inf
    above: float = inf


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
    """Reach envelopes that a study asks for: whose, by which hand, grip and zone, and whether
    obstacles are heeded."""

    person: str
    limb: str
    grip: str
    zone: int
    obstacles: bool


@dataclass(frozen=True, eq=False)
class Size:
    """A person's measures [m; mass in kg], and the population whose people the other measures are
    taken from, or the growth charts and the age [years] of a child."""

    sex: str
    measures: Mapping[str, float]
    population: PopulationModel | Growth
    age: float | None = None


@dataclass(frozen=True, eq=False)
class Person:
    """One body in all cases of a study: P poses, one a case.

    seat: the seat it is put into (its adjustment `forward` and `up` [m]); or `stand`: a point (3,)
    [m] that the lowest sphere stands on; or neither, where the poses are placed already. size: the
    measures the body is scaled to when the study runs, None for the body as it is. detail: the
    level of detail of its family, its own where None; wears: what it is dressed in then. aims: by
    case, what the posture is predicted from, None where it is given; free_seat: the seat goes where
    the first predicted case wants it. held: by case, True where the poses say where the sitter is
    and the seat's planes do not: a driver sits by the hip point.
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


@dataclass(frozen=True, eq=False)
class Study:
    """A study ready to run. `inputs` are the files it was read from, by role; `envelopes` the reach
    envelopes asked for."""

    name: str
    kind: str
    title: str
    description: str
    environment: Environment
    people: tuple[Person, ...]
    cases: tuple[str, ...]
    criteria: tuple[Criterion, ...]
    inputs: Mapping[str, Path]
    warnings: tuple[str, ...] = ()
    envelopes: tuple[ReachTask, ...] = ()
