"""A workplace: what a role does in the postures of a study and what it must meet, apart from who
takes the role."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from workbench.model.arguments import short_repr
from workbench.model.arrays import Bools, Floats
from workbench.model.bystander import Bystander
from workbench.model.criterion import Criterion
from workbench.model.driving import DrivingAims
from workbench.model.environment import Environment, Seat
from workbench.model.poses import Placed, Poses

__all__ = ["Beside", "PostureGoals", "Stand", "WorkCase", "Workplace"]


Interval = tuple[float, float]


@dataclass(frozen=True)
class Stand:
    """Where somebody stands, and the area within which the feet may step.

    Parameters
    ----------
    on
        (3,) [m] the point of the floor that is stood on.
    yaw
        Heading [rad], 0 along x.
    forward, left
        (low, high) [m] how far the person may step from the point, ahead and to the left as the
        person faces. Both nothing where the feet stay.
    """

    on: tuple[float, float, float]
    yaw: float = 0.0
    forward: Interval = (0.0, 0.0)
    left: Interval = (0.0, 0.0)

    @property
    def steps(self) -> bool:
        """Whether there is an area to step in."""
        return self.forward != (0.0, 0.0) or self.left != (0.0, 0.0)

    def floor(self, positions: Floats) -> Floats:
        """(B, 3) [m] the points of the floor at positions (B, 2) [m], forward and left."""
        ahead = np.array([np.cos(self.yaw), np.sin(self.yaw), 0.0])
        left = np.array([-ahead[1], ahead[0], 0.0])
        return np.array(self.on) + positions[:, :1] * ahead + positions[:, 1:] * left


@dataclass(frozen=True)
class PostureGoals:
    """What a sitter's posture is predicted from: by limb ("left hand", ...) the control that it
    holds; the point whose height the eyes are to reach and the point on the floor whose height the
    heels stand at, None where any. driving: of a driver at the wheel, whose posture is the
    statistical one."""

    controls: Mapping[str, str]
    eyes: str | None = None
    heels: str | None = None
    driving: DrivingAims | None = None


@dataclass(frozen=True, eq=False)
class WorkCase:
    """A case that is a posture, of one role.

    Parameters
    ----------
    name
        The name of the case.
    posture
        The name of the posture: of trunk and head alone where the rest is predicted.
    pose
        That posture (P = 1) of the body as its file has it.
    aims
        What the posture is predicted from, None where it is given.
    hands
        Of a given posture, by hand the control that it holds.
    """

    name: str
    posture: str
    pose: Poses
    aims: PostureGoals | None = None
    hands: Mapping[str, str] = field(default_factory=dict)

    __repr__ = short_repr

    @property
    def held(self) -> Mapping[str, str]:
        """By limb ("left hand", ...) the control that it holds."""
        return self.hands if self.aims is None else self.aims.controls


@dataclass(frozen=True, eq=False)
class Beside:
    """Somebody who is there too.

    Parameters
    ----------
    role
        The name of the role.
    placed
        (P,) the body in each of the cases.
    solid
        (P, S) the spheres that hands of others keep clear of in each case.
    """

    role: str
    placed: Placed
    solid: Bools

    def in_case(self, case: int) -> Bystander:
        """The person in one of the cases."""
        here = self.placed.of_person(0, np.array([case]))
        return Bystander(self.role, here, self.solid[case])


@dataclass(frozen=True, eq=False)
class Workplace:
    """Where a role is and what it does, case by case.

    Parameters
    ----------
    role
        The name of the role.
    environment
        The surroundings. The seats of others stand where these have put them; the own seat has the
        travel that may be used.
    cases
        The cases that are postures.
    criteria
        What is asked of the role. `between_people` is asked about those who are `beside`.
    seat
        The own seat, None for somebody who stands, or is where the poses say.
    stand
        The point that the lowest sphere stands on, and the area to step in, where there is one.
    beside
        Others who are there too, each with a pose for every case. Hands keep clear of them.
    adjusts
        The adjustments of the environment that the role may make.
    """

    role: str
    environment: Environment
    cases: tuple[WorkCase, ...]
    criteria: tuple[Criterion, ...]
    seat: str | None = None
    stand: Stand | None = None
    beside: tuple[Beside, ...] = ()
    adjusts: tuple[str, ...] = ()

    __repr__ = short_repr

    @property
    def own_seat(self) -> Seat | None:
        """The own seat with its travel."""
        return None if self.seat is None else self.environment.seat(self.seat)

    @property
    def travel(self) -> tuple[Interval, Interval]:
        """[m] how far the position may be from the one stated: forward and up of a seat, forward
        and left of somebody who stands."""
        seat = self.own_seat
        if seat is not None:
            return seat.travel_forward, seat.travel_up
        if self.stand is not None:
            return self.stand.forward, self.stand.left
        return (0.0, 0.0), (0.0, 0.0)

    @property
    def goes(self) -> bool:
        """Whether there are ends of a travel: of a seat, or of an area to step in."""
        return self.own_seat is not None or (self.stand is not None and self.stand.steps)

    @property
    def moving_parts(self) -> tuple[str, ...]:
        """The parts that move with the own seat."""
        seat = self.own_seat
        return () if seat is None else seat.moves

    def carried(self, case: int) -> bool:
        """Whether another position carries the whole body along in a case, so that its posture is
        the same in all: of somebody who stands as stated, and holds nothing."""
        work = self.cases[case]
        return self.stand is not None and work.aims is None and not work.held

    @property
    def first_predicted(self) -> int:
        """The index of the case that decides where the seat is wanted: the first whose posture is
        predicted, 0 where none is."""
        return next((k for k, case in enumerate(self.cases) if case.aims is not None), 0)
