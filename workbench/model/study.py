"""Study: who is where in which environment, what each does, and what must hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal

from workbench.errors import InputError
from workbench.model.accommodation import Change, IntervalRule, MapTask
from workbench.model.arguments import above, checked, short_repr
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.envelope import ReachTask
from workbench.model.environment import Environment
from workbench.model.motion_case import SignalPoint
from workbench.model.person import Encumbrance, Size
from workbench.model.population import Population, PopulationModel
from workbench.model.poses import Poses
from workbench.model.simulation import ForceLaw, Restraints
from workbench.model.surroundings import Move
from workbench.model.workplace import PostureGoals, Stand

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
    "Statement",
    "Study",
    "sealed",
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

    __repr__ = short_repr


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
    aims: PostureGoals


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """A motion file and how it is read.

    begin, end [s] and every: the frames wanted; names: bones by segment, or usual marker names by
    the file's; up: its upward axis; metres: one unit of a BVH or marker file [m]; gaps [s]: the longest that
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

    __repr__ = short_repr

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
    """The points whose signals are reported, and the filter of those that only rules are about."""

    points: tuple[SignalPoint, ...] = ()
    filter_class: int | Literal["j211"] | None = None


@dataclass(frozen=True)
class ContactForce:
    """The force law of some segments against some parts, by their names."""

    segments: tuple[str, ...]
    parts: tuple[str, ...]
    law: ForceLaw


@dataclass(frozen=True, eq=False, repr=False)
class Statement:
    """What a study says, from which all its other fields are derived.

    value: keys and values of the format of study files, as a file or a call has them; path: a file
    in the folder from which names are looked for; derived: the study's other fields by name.
    """

    value: Mapping[str, Any]
    path: Path
    derived: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, repr=False)
class Study:
    """A study with everything it names, as `load_study`, `study` and `with_` make it.

    settings: where the study states that adjustments are set [m or rad], by name; `environment` has
    them so. moved: what of the environment stands elsewhere than its file has it; `environment` has it
    there. compare: the two cases whose motions are compared, by index. inputs: the files it was read from,
    by role. statement: what it says, None where the study was put together by hand.

    Fields depend on each other: to change one, let `with_` derive all of them anew.
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
    statement: Statement | None = None

    def __repr__(self) -> str:
        people = ", ".join(role.name for role in self.roles)
        counts = f"cases: {len(self.cases)}, criteria: {len(self.criteria)}"
        doubts = f", warnings: {len(self.warnings)}" if self.warnings else ""
        return f"Study({self.name}: {people} in {self.environment.name}; {counts}{doubts})"

    def check_derived(self) -> Statement:
        """Return what the study says.

        Raises
        ------
        InputError
            If a field was changed by hand since it was derived from what the study says, or the
            whole study was put together by hand: fields then contradict each other in silence.
        """
        if self.statement is None:
            raise InputError(
                f"study {self.name}: was put together by hand, so nothing of it is checked; make it "
                "with wb.load_study(...) or wb.study(...)"
            )
        derived = self.statement.derived.items()
        changed = [name for name, value in derived if getattr(self, name) is not value]
        if changed:
            names = ", ".join(changed)
            raise InputError(
                f"study {self.name}: {names} changed by hand (dataclasses.replace), while the other "
                "fields are still those of the study as it was; let study.with_(...) derive them all "
                "anew, as in study.with_(moved=[{'parts': ['panel'], 'by': [0.02, 0, 0]}])"
            )
        return self.statement

    @checked
    def with_(
        self,
        *,
        environment: Any = None,
        people: Mapping[str, Any] | None = None,
        cases: Mapping[str, Any] | Sequence[Any] | None = None,
        criteria: Mapping[str, Any] | Sequence[Any] | None = None,
        name: str | None = None,
        title: str | None = None,
        description: str | None = None,
        postures: Mapping[str, Any] | None = None,
        moved: Mapping[str, Any] | Sequence[Any] | None = None,
        shares: Mapping[str, Any] | None = None,
        reach_maps: Sequence[Any] | None = None,
        reach_envelopes: Sequence[Any] | None = None,
        changes: Mapping[str, Any] | Sequence[Any] | None = None,
        compare: Sequence[str] | None = None,
        signals: Mapping[str, Any] | None = None,
        contact_forces: Sequence[Any] | None = None,
    ) -> Study:
        """Change what the study says and derive it anew, with every check of a study file.

        A mapping changes the keys that it names and leaves the others, at any depth; None takes a
        key away. In the place of a list of named things (cases, criteria, changes) a mapping of
        names to changes changes those of these names. Everything else takes the place of what
        was there; an empty list takes it away.

        Parameters
        ----------
        environment
            As for `study`.
        name
            Of the study.
        moved
            As for `study`; all moves, from where the environment has things.
        people, cases, criteria, title, description, postures, shares, reach_maps, reach_envelopes,         changes, compare, signals, contact_forces
            As in a study file. Lengths are numbers [m], also where the file counts in another unit,
            or texts with their unit ("20 mm"); angles are degrees.

        Returns
        -------
        Study
            Another study; this one stays as it is.

        Raises
        ------
        InputError
            With a line for each fault, which names the argument; or if a field of this study was
            changed by hand.
        """
        given = {
            "study": name,
            "title": title,
            "description": description,
            "environment": environment,
            "people": people,
            "postures": postures,
            "moved": moved,
            "cases": cases,
            "criteria": criteria,
            "shares": shares,
            "reach_maps": reach_maps,
            "reach_envelopes": reach_envelopes,
            "changes": changes,
            "compare": compare,
            "signals": signals,
            "contact_forces": contact_forces,
        }
        return above("files.study.stating", "changed_study")(self, given)

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


def sealed(study: Study, statement: Statement) -> Study:
    """A study with what it says, of which its fields as they are now are derived."""
    derived = {one.name: getattr(study, one.name) for one in fields(study)}
    del derived["statement"]
    return replace(study, statement=replace(statement, derived=derived))
