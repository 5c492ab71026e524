"""Study: who is where in which environment, what each does, and what must hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from workbench.model.accommodation import Change, IntervalRule, MapTask
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.encumbrance import Encumbrance
from workbench.model.envelope import ReachTask
from workbench.model.environment import Environment
from workbench.model.force import ForceLaw
from workbench.model.motion_case import SignalPoint
from workbench.model.moves import Move
from workbench.model.person import Size
from workbench.model.population import Population, PopulationModel
from workbench.model.poses import Poses
from workbench.model.simulation import Restraints
from workbench.model.workplace import Aims, Stand

__all__ = [
    "Action",
    "Case",
    "ContactForce",
    "GivenPosture",
    "PeopleDrawn",
    "PredictedPosture",
    "RecordedMotion",
    "Role",
    "Shares",
    "Signals",
    "SimulatedMotion",
    "Study",
]


@dataclass(frozen=True, eq=False)
class PeopleDrawn:
    """People who are to be drawn from a population: how many, the seed, the share (0 to 1) who are
    women, and whether they are like the measured people instead of these themselves."""

    model: PopulationModel
    people: int
    seed: int
    women: float
    synthetic: bool = False


@dataclass(frozen=True, eq=False)
class Role:
    """Somebody who takes part in every case.

    body: as its file has it; detail: the level of it that is used, its own where None. size: the
    measures the body is scaled to; sizes: several of them by name, or population: many people, who
    take the role one at a time; none of these for the body as it is. seat: whose position [m] is `forward` and `up`, or found where `free`.
    stand: the point that the lowest sphere stands on, and the area to step in; it is stepped where
    `free`. Where neither is given, poses say where the body is. adjusts: the adjustments of the environment that the person may make.
    library: a pose in each posture that can be named.
    """

    name: str
    body: Body
    detail: str | None = None
    clothes: tuple[Encumbrance, ...] = ()
    size: Size | None = None
    sizes: Mapping[str, Size] = field(default_factory=dict)
    population: Population | PeopleDrawn | None = None
    seat: str | None = None
    free: bool = False
    forward: float = 0.0
    up: float = 0.0
    stand: Stand | None = None
    adjusts: tuple[str, ...] = ()
    library: Mapping[str, Poses] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class GivenPosture:
    """A posture by its name: one pose, in the world where the role is at a place.

    hands: by hand ("left hand", ...) the control that it holds; the arm is solved from the pose.
    """

    name: str
    poses: Poses
    hands: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class PredictedPosture:
    """A posture to be predicted from aims, trunk and head as in the posture `like` (one pose).

    With `aims.driving` it is a driver's.
    """

    like: str
    poses: Poses
    aims: Aims


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """A motion file and how it is read.

    begin, end [s] and every: the frames wanted; names: bones by segment, or usual marker names by
    the file's; up: its upward axis; metres: one unit of a BVH file [m]; gaps [s]: the longest that
    is bridged; as_read: whether a header may state a wrong number of frames; move (3,) [m] and yaw [rad]: where it is put; subject: whether the body takes the
    lengths that the file shows.
    """

    file: Path
    begin: float
    end: float
    every: int
    names: Mapping[str, str]
    up: str | None
    metres: float | None
    gaps: float
    as_read: bool
    move: tuple[float, float, float]
    yaw: float
    subject: bool
    restraints: Restraints


@dataclass(frozen=True, eq=False)
class SimulatedMotion:
    """A motion to be simulated: the simulation's file, the posture it starts from and its pose."""

    simulation: Path
    start: str
    poses: Poses
    restraints: Restraints


Action = GivenPosture | PredictedPosture | RecordedMotion | SimulatedMotion


@dataclass(frozen=True, eq=False)
class Case:
    """A case: what each role does, in the order of the roles."""

    name: str
    actions: tuple[Action, ...]

    @property
    def moves(self) -> bool:
        """Whether it is a motion."""
        return isinstance(self.actions[0], (RecordedMotion, SimulatedMotion))


@dataclass(frozen=True)
class Shares:
    """How shares of a population are reported: mixes (share of women, 0 to 1, by name), the
    confidence (0 to 1) of intervals, and how these are found."""

    mixes: Mapping[str, float] = field(default_factory=dict)
    confidence: float = 0.95
    interval: IntervalRule = field(default_factory=IntervalRule)


@dataclass(frozen=True)
class Signals:
    """The points whose signals are reported, and the class of the filter."""

    points: tuple[SignalPoint, ...] = ()
    filter_class: int | None = None


@dataclass(frozen=True)
class ContactForce:
    """The force law of some segments against some parts, by their names."""

    segments: tuple[str, ...]
    parts: tuple[str, ...]
    law: ForceLaw


@dataclass(frozen=True, eq=False)
class Study:
    """A study with everything it names.

    settings: where the study states that adjustments are set [m or rad], by name; `environment` has
    them so. moved: what of the environment stands elsewhere than its file has it; `environment` has it
    there. compare: the two cases whose motions are compared, by index. inputs: the files it was read from,
    by role.
    """

    name: str
    title: str
    description: str
    environment: Environment
    roles: tuple[Role, ...]
    cases: tuple[Case, ...]
    criteria: tuple[Criterion, ...]
    inputs: Mapping[str, Path]
    settings: Mapping[str, float] = field(default_factory=dict)
    moved: tuple[Move, ...] = ()
    shares: Shares = field(default_factory=Shares)
    reach_maps: tuple[MapTask, ...] = ()
    reach_envelopes: tuple[ReachTask, ...] = ()
    changes: tuple[Change, ...] = ()
    compare: tuple[int, int] | None = None
    signals: Signals = field(default_factory=Signals)
    contact_forces: tuple[ContactForce, ...] = ()
    warnings: tuple[str, ...] = ()

    def by_size(self) -> list[tuple[str, Study]]:
        """A study for each of the sizes that take a role one at a time, by their names; the study
        itself where there are none."""
        several = next((row for row, role in enumerate(self.roles) if role.sizes), None)
        if several is None:
            return [("", self)]
        found = []
        for name, size in self.roles[several].sizes.items():
            roles = list(self.roles)
            roles[several] = replace(roles[several], size=size, sizes={})
            found.append((name, replace(self, roles=tuple(roles))))
        return found

    @property
    def crowd(self) -> Role | None:
        """The role that a population takes, None where there is none."""
        return next((role for role in self.roles if role.population is not None), None)

    @property
    def share_criteria(self) -> tuple[Criterion, ...]:
        """The criteria that ask for a share of the population."""
        return tuple(criterion for criterion in self.criteria if criterion.check == "share")

    @property
    def motions(self) -> tuple[Case, ...]:
        """The cases that are motions."""
        return tuple(case for case in self.cases if case.moves)

    @property
    def postures(self) -> tuple[Case, ...]:
        """The cases that are postures."""
        return tuple(case for case in self.cases if not case.moves)
