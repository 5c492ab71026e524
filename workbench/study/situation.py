"""Situations: people put into their workplace, as every check looks at them.

Who is seated by a prediction takes the lowest position of the seat that still gives the view, then
the pedals, then the controls with the hands, each in the tightest harness zone that will do. This
is the order of Zehner and Kennedy's cockpit assessments. Who stands by a prediction bends, and steps
within the area, as is most comfortable for the controls; then the hands go there.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from workbench.body.forward import place
from workbench.contact.collide import nearest, self_clearance
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.bystander import Bystander
from workbench.model.contacts import Clearance
from workbench.model.content import content_key
from workbench.model.criterion import Reason
from workbench.model.driving import DrivingAims, Package
from workbench.model.environment import Control, Environment, Seat
from workbench.model.population import Population, sex_index
from workbench.model.poses import Placed, Poses
from workbench.model.surroundings import moved_along
from workbench.model.workplace import PostureGoals, Stand, WorkCase, Workplace
from workbench.posture.kernels.clear_reach import KEPT
from workbench.posture.reaching.heeding import clear_fingers
from workbench.posture.reaching.history import ReachHistory, Recall
from workbench.posture.reaching.limbs import FEET, HANDS, ZONES, Limb, limb
from workbench.posture.reaching.obstacles import ObstacleScene
from workbench.posture.reaching.oneself import in_own_legs
from workbench.posture.reaching.reach import reach
from workbench.posture.seating.clear_legs import clear_legs
from workbench.posture.seating.driving import driving_posture
from workbench.posture.seating.driving_legs import accelerator_foot
from workbench.posture.seating.posture import Pedals
from workbench.posture.seating.seat import Seated, SeatMemory, seat
from workbench.posture.standing import standing_posture
from workbench.sight.eyes import head_of
from workbench.sight.scenery import Scenery, scenery_of
from workbench.study.persons import drivers_among

__all__ = [
    "Occupants",
    "Remembered",
    "Seating",
    "Situation",
    "TakenPlaces",
    "as_bystander",
    "feet_of",
    "freely_seated",
    "hands_moved",
    "in_place",
    "moved_by",
    "moved_by_hands",
    "moved_by_legs",
    "on_fixed_pedals",
    "package_of",
    "position_of",
    "seating_of",
    "situated",
    "solid_to_others",
    "take_places",
    "with_clear_legs",
    "with_hands",
    "with_hands_again",
    "with_some_hands",
    "without_parts",
    "without_seat",
]


ARMS_ALONE = 2
"""The freest harness zone in which a hand moves its arm and nothing of the trunk."""


@dataclass(frozen=True, eq=False)
class Occupants:
    """B people who take a role, one at a time: rows of a body.

    Parameters
    ----------
    body
        B rows, at their size and dressed.
    people
        The people they are taken from.
    numbers
        (B,) the row of each in `people`.
    first
        The number by which the driving posture of the first of `people` is drawn.
    seats
        Where they were seated before; None where that is not kept.
    """

    body: Body
    people: Population
    numbers: Ints
    first: int = 0
    seats: SeatMemory | None = None

    def __len__(self) -> int:
        return len(self.body)

    def rows(self, keep: Ints) -> Occupants:
        """The people at indices, in their order."""
        return replace(self, body=self.body[keep], numbers=self.numbers[keep])


@dataclass(frozen=True, eq=False)
class TakenPlaces:
    """The places that B people have taken: their poses in the world with the hands at rest, how
    the seat came out, None for people without one, and (B, 2) [m] how far those who stand have
    stepped, forward and left; and how the seat came out before the legs heeded what stands around,
    None where these did not."""

    poses: Poses
    seated: Seated | None
    stepped: Floats
    heedless: Seated | None = None

    def rows(self, keep: Ints) -> TakenPlaces:
        """The people at indices, in their order."""
        seated = self.seated.rows(keep) if self.seated else None
        heedless = self.heedless.rows(keep) if self.heedless else None
        return TakenPlaces(self.poses.rows(keep), seated, self.stepped[keep], heedless)


@dataclass(frozen=True, eq=False)
class Remembered:
    """What N people of a workplace were found to reach in other positions of their seats.

    Parameters
    ----------
    count
        N.
    who
        (B,) which of them the people of a situation are.
    histories
        By what is asked for, filled as it is asked.
    few_starts
        Whether few starts are tried for everything.
    once
        Whether few starts are tried for what was searched for whole once.
    searching
        Whether a position is only searched for: then what is proved to be kept is left where it is,
        and it is not asked how much farther a limb could go.
    """

    count: int
    who: Ints
    histories: dict[tuple[object, ...], ReachHistory]
    few_starts: bool = False
    once: bool = False
    searching: bool = False

    def elsewhere(self) -> Remembered:
        """The same, where parts stand elsewhere."""
        histories = {key: history.elsewhere() for key, history in self.histories.items()}
        return replace(self, histories=histories)

    def rows(self, keep: Ints) -> Remembered:
        """That of the people at indices."""
        return replace(self, who=self.who[keep])

    def recall(
        self, place: Workplace, key: tuple[object, ...], controls: Sequence[Control]
    ) -> Recall:
        """The history of some controls of a workplace, asked for in the way named `key`."""
        names = [control.name for control in place.environment.controls]
        if key not in self.histories:
            self.histories[key] = ReachHistory(self.count * len(names))
        column = np.array([names.index(control.name) for control in controls])
        row = self.who[:, None] * len(names) + column
        return Recall(self.histories[key], row, self.once, self.few_starts)


@dataclass(frozen=True, eq=False)
class Situation:
    """B people in one case of their workplace.

    Parameters
    ----------
    place, case
        The workplace and the index of the case.
    body
        B rows.
    taken
        Where they are, with the hands at rest: reaches begin there.
    poses
        (B,) their postures, a pose of each row of the body.
    displacement
        (B, 3) [m] of the parts that move with the own seat.
    spare
        (B, 2) [m] the travel that is left to the rear and to the front where the seat is wanted.
    male
        (B,) whether they are men; of somebody whose sex is not known True.
    bystanders
        Other people, whom the hands keep clear of.
    hand_miss, hand_overlap, hand_limit
        (B,) by hand that holds a control: [m] how far it stays from it, [m] how deep the arm is in
        an obstacle, and what limits it; empty while the hands are at rest.
    """

    place: Workplace
    case: int
    body: Body
    taken: TakenPlaces
    poses: Poses
    displacement: Floats
    spare: Floats
    male: Bools
    bystanders: tuple[Bystander, ...] = ()
    hand_miss: Mapping[str, Floats] = field(default_factory=dict)
    hand_overlap: Mapping[str, Floats] = field(default_factory=dict)
    hand_limit: Mapping[str, tuple[Reason, ...]] = field(default_factory=dict)
    unsure: Bools | None = None
    """(B,) whose hands were not searched for wherever they may be; None where all were."""
    remembered: Remembered | None = None
    """What the people reached elsewhere; None where nobody asks elsewhere."""

    def __len__(self) -> int:
        return len(self.poses)

    @property
    def environment(self) -> Environment:
        """The surroundings, with the own seat in its reference position."""
        return self.place.environment

    @property
    def work(self) -> WorkCase:
        """What is done."""
        return self.place.cases[self.case]

    def freest(self, control: Control) -> int:
        """The freest harness zone in which a hand comes to a control that it holds. Who bends for it
        does so before, see `take_places`: then the arm alone moves."""
        bends = self.work.aims is not None and self.place.seat is None
        return ARMS_ALONE if bends else control.zone

    @property
    def seated(self) -> Seated | None:
        """How the seat came out, None for people without one."""
        return self.taken.seated

    @property
    def eyes(self) -> str | None:
        """The point whose height the eyes are to reach, None where any will do."""
        return self.work.aims.eyes if self.work.aims is not None else None

    @cached_property
    def placed(self) -> Placed:
        """(B,) the bodies in the world."""
        return place(self.body, self.poses)

    @cached_property
    def scenery(self) -> Scenery:
        """What may stand before the eyes: all parts, the people themselves, others who are there."""
        return scenery_of(
            self.environment,
            self.placed,
            {one.name: one.placed for one in self.bystanders},
            moving=self.place.moving_parts,
            displacement=self.displacement,
        )

    @cached_property
    def still_scenery(self) -> Scenery | None:
        """What stands before the eyes wherever the hands are that hold something, and the legs: all
        parts, and of the people what these do not move. None where they move the head."""
        moved = moved_by_hands(self) | moved_by_legs(self)
        if moved[self.body.sphere_segment == head_of(self.body)].any():
            return None
        return scenery_of(
            self.environment,
            self.placed,
            moving=self.place.moving_parts,
            displacement=self.displacement,
            without=moved,
        )

    @cached_property
    def nearest(self) -> Clearance:
        """The nearest pairs of segments and parts, with the own seat in its reference position."""
        return nearest(self.placed, self.environment, through=True)

    @cached_property
    def own(self) -> Clearance:
        """The nearest pairs of segments of the same body."""
        return self_clearance(self.placed)

    @cached_property
    def held(self) -> Situation:
        """The same with the hands on the controls that they hold, see `with_hands`."""
        return _hands_placed(self)

    @property
    def hands_placed(self) -> bool:
        """Whether the hands were brought to the controls that they hold already."""
        return "held" in self.__dict__

    @cached_property
    def at_rest(self) -> Situation:
        """The same with the hands at rest and nobody whom they keep clear of."""
        return replace(
            self,
            poses=self.taken.poses,
            bystanders=(),
            hand_miss={},
            hand_overlap={},
            hand_limit={},
        )

    def rows(self, keep: Ints) -> Situation:
        """The people at indices, in their order, with what is known of them."""
        found = Situation(
            place=self.place,
            case=self.case,
            body=self.body[keep],
            taken=self.taken.rows(keep),
            poses=self.poses.rows(keep),
            displacement=self.displacement[keep],
            spare=self.spare[keep],
            male=self.male[keep],
            bystanders=self.bystanders,
            hand_miss=_rows_of(self.hand_miss, keep),
            hand_overlap=_rows_of(self.hand_overlap, keep),
            hand_limit=_limit_of(self, keep),
            unsure=self.unsure[keep] if self.unsure is not None else None,
            remembered=self.remembered.rows(keep) if self.remembered is not None else None,
        )
        if self.hands_placed:
            found.__dict__["held"] = replace(
                found,
                poses=self.held.poses.rows(keep),
                hand_miss=_rows_of(self.held.hand_miss, keep),
                hand_overlap=_rows_of(self.held.hand_overlap, keep),
                hand_limit=_limit_of(self.held, keep),
                unsure=self.held.unsure[keep] if self.held.unsure is not None else None,
            )
        return found

    @property
    def environment_moved(self) -> Environment:
        """The surroundings with the own seat where the first person has put it."""
        if self.place.seat is None:
            return self.environment
        return moved_along(self.environment, self.place.moving_parts, self.displacement[0])

    def where(self, controls: Sequence[Control]) -> Floats:
        """(B, T, 3) [m] where controls are for each person: what is on the own seat goes with it."""
        at = np.reshape([control.at for control in controls], (len(controls), 3))
        along = np.isin([control.part for control in controls], self.place.moving_parts)
        found: Floats = at + along[:, None] * self.displacement[:, None]
        return found

    def seat_moved(self, environment: Environment) -> Situation:
        """The same in surroundings where the own seat stands where it was put."""
        place = replace(self.place, environment=environment)
        return replace(self, place=place, displacement=np.zeros_like(self.displacement))


def _rows_of(by_hand: Mapping[str, Floats], keep: Ints) -> dict[str, Floats]:
    return {hand: values[keep] for hand, values in by_hand.items()}


def _limit_of(situation: Situation, keep: Ints) -> dict[str, tuple[Reason, ...]]:
    return {hand: tuple(limits[k] for k in keep) for hand, limits in situation.hand_limit.items()}


@dataclass(frozen=True, eq=False)
class Seating:
    """What decides where people are in one case: the whole input of `take_places`, so that a key of
    kept places is made from it and nothing else can move people.

    Parameters
    ----------
    seat, stand
        The seat with its travel, or where somebody stands, None where there is none.
    pose
        The posture that the prediction begins from, or the posture itself (P = 1).
    pedals
        Where the feet go, None where the legs stay as the posture has them.
    eye
        Height [m] that the eyes are to reach, None where any.
    driving, package
        Of drivers.
    hands
        Of a predicted posture of somebody who stands: by hand the grip and the point (3,) [m] where
        it goes, None where the posture is given.
    """

    seat: Seat | None
    stand: Stand | None
    pose: Poses
    pedals: Pedals | None = None
    eye: float | None = None
    driving: DrivingAims | None = None
    package: Package | None = None
    hands: Mapping[str, tuple[str, tuple[float, float, float]]] | None = None


def seating_of(place: Workplace, case: int) -> Seating:
    """What decides where people are in a case of a workplace."""
    work = place.cases[case]
    aims = work.aims
    if aims is None:
        return Seating(place.own_seat, place.stand, work.pose)
    points = place.environment.points
    feet = feet_of(aims, place.environment)
    return Seating(
        seat=place.own_seat,
        stand=place.stand,
        pose=work.pose,
        pedals=Pedals(
            feet, points[aims.heels][2] if aims.heels else None, _feet_along(place, aims)
        ),
        eye=points[aims.eyes][2] if aims.eyes else None,
        driving=aims.driving,
        package=package_of(aims, place.environment) if aims.driving is not None else None,
        hands=_held_points(aims, place.environment) if place.seat is None else None,
    )


def _held_points(
    aims: PostureGoals, environment: Environment
) -> dict[str, tuple[str, tuple[float, float, float]]]:
    """By hand the grip, and where the control is [m] that it holds."""
    controls = {control.name: control for control in environment.controls}
    held = {hand: controls[name] for hand, name in aims.controls.items() if hand in HANDS}
    return {hand: (control.grip, control.at) for hand, control in held.items()}


def feet_of(aims: PostureGoals, environment: Environment) -> dict[str, tuple[float, float, float]]:
    """Where the balls of the feet go [m], by "left foot" and "right foot"."""
    controls = {control.name: control for control in environment.controls}
    return {foot: controls[held].at for foot, held in aims.controls.items() if foot in FEET}


def _feet_along(place: Workplace, aims: PostureGoals) -> tuple[str, ...]:
    """The feet that are on something that the own seat takes along, such as footplates."""
    along = [one.name for one in place.environment.controls if one.part in place.moving_parts]
    return tuple(foot for foot, name in aims.controls.items() if foot in FEET and name in along)


def package_of(aims: PostureGoals, environment: Environment) -> Package:
    """The package a driver sits in: the heel's point, the accelerator, the wheel's centre, the
    seat's hip point."""
    assert aims.driving is not None and aims.heels is not None
    points = environment.points
    feet = feet_of(aims, environment)
    return Package(
        heel=points[aims.heels],
        ball=feet[accelerator_foot(feet, points[aims.heels])],
        wheel=points[aims.driving.wheel],
        h_point=points[aims.driving.h_point],
    )


def take_places(seating: Seating, who: Occupants, positions: Floats | None = None) -> TakenPlaces:
    """Let people take their places in a case.

    Parameters
    ----------
    positions
        (B, 2) [m] forward and up, where the seat of each stands; forward and left, how far each has
        stepped. None: where it is comfortable within the travel; without a step where a posture is
        given.
    """
    body = who.body
    poses = _pose_of_each(seating, body)
    stepped = np.zeros((len(body), 2))
    if seating.seat is None:
        if seating.stand is None:
            return TakenPlaces(poses, None, stepped)
        if seating.hands:
            return _bent(seating, seating.stand, body, poses, positions)
        stepped = stepped if positions is None else positions
        return TakenPlaces(_standing(body, poses, seating.stand.floor(stepped)), None, stepped)
    found = _remembered(seating, who, poses, positions)
    return TakenPlaces(found.poses, found, stepped)


def _remembered(seating: Seating, who: Occupants, poses: Poses, positions: Floats | None) -> Seated:
    """Seat people; who was seated in a position before is remembered, whatever the travel was."""
    assert seating.seat is not None
    if positions is None or who.seats is None:
        return _seated(seating, who, poses, positions)
    anywhere = replace(seating.seat, travel_forward=(0.0, 0.0), travel_up=(0.0, 0.0))
    held = replace(seating, seat=anywhere)

    def some(rows: Ints) -> Seated:
        return _seated(held, who.rows(rows), poses.rows(rows), positions[rows])

    return who.seats.seated(content_key("seats", held), who.numbers, positions, some)


def _seated(seating: Seating, who: Occupants, poses: Poses, positions: Floats | None) -> Seated:
    """Seat people, of whom drivers come to the wheel."""
    assert seating.seat is not None
    if seating.driving is None:
        return seat(
            who.body, poses, seating.seat, eye=seating.eye, pedals=seating.pedals, held=positions
        )
    assert seating.package is not None and seating.pedals is not None
    return driving_posture(
        who.body,
        poses,
        seating.seat,
        drivers=drivers_among(who.people, who.numbers.tolist(), who.body, seating.driving),
        seed=seating.driving.seed,
        package=seating.package,
        feet=seating.pedals.at,
        eye=seating.eye,
        numbers=(who.first + who.numbers).tolist(),
        positions=positions,
    )


def on_fixed_pedals(situation: Situation) -> bool:
    """Whether a foot is on a pedal that stays where it is when the seat goes."""
    pedals = seating_of(situation.place, situation.case).pedals
    return pedals is not None and not set(pedals.at) <= set(pedals.along)


def freely_seated(situation: Situation, more: float) -> Seated | None:
    """The people of a situation where pedals and view would have their seats, if these went so much
    [m] farther back and forward and thighs could hang as they will; None of drivers and of people
    without a seat or pedals that stay where they are."""
    seating = seating_of(situation.place, situation.case)
    seat_of = seating.seat
    if seat_of is None or seating.driving is not None or not on_fixed_pedals(situation):
        return None
    low, high = seat_of.travel_forward
    return seat(
        situation.body,
        _pose_of_each(seating, situation.body),
        replace(seat_of, travel_forward=(low - more, high + more), front=None),
        eye=seating.eye,
        pedals=seating.pedals,
    )


def _pose_of_each(seating: Seating, body: Body) -> Poses:
    """The posture of a seating for each row of a body; of a predicted one placed by the pelvis,
    which the seat carries."""
    pose = seating.pose
    reference = pose.reference
    world = pose.world_from_reference
    if seating.pedals is not None:
        reference = body.segment("LT")
        world = place(body[0], pose).world_from_segment[:, reference]
    count = len(body)
    return Poses(
        np.repeat(pose.rotations, count, axis=0), reference, np.repeat(world, count, axis=0)
    )


def _standing(body: Body, poses: Poses, floor: Floats) -> Poses:
    """Bodies whose lowest spheres rest at the height of points (B, 3) [m], their reference segments
    over these."""
    centres = place(body, poses).centres
    lowest = np.min(centres[:, :, 2] - body.radius, axis=1)
    world = poses.world_from_reference.copy()
    world[:, :2, 3] = floor[:, :2]
    world[:, 2, 3] += floor[:, 2] - lowest
    return Poses(poses.rotations, poses.reference, world)


def _bent(
    seating: Seating, stand: Stand, body: Body, poses: Poses, positions: Floats | None
) -> TakenPlaces:
    """People who bend and step so that their hands come to where they go; the arms are at rest
    again."""
    assert seating.hands is not None
    start = np.zeros((len(body), 2)) if positions is None else positions
    upright = _standing(body, poses, stand.floor(start))
    area = (stand.forward, stand.left) if positions is None else ((0.0, 0.0), (0.0, 0.0))
    found = standing_posture(body, upright, seating.hands, area=area, heading=stand.yaw)
    rotations = found.poses.rotations.copy()
    for hand, (grip, _) in seating.hands.items():
        arm = list(limb(body, hand, grip=grip, zone=ARMS_ALONE).free)
        rotations[:, arm] = upright.rotations[:, arm]
    bent = replace(found.poses, rotations=rotations)
    return TakenPlaces(bent, None, start + found.stepped)


def situated(
    place: Workplace,
    case: int,
    who: Occupants,
    positions: Floats | None = None,
    *,
    heedless: bool = False,
) -> Situation:
    """Put people into a case of their workplace, with the hands at rest.

    Parameters
    ----------
    positions
        As of `take_places`.
    heedless
        As of `in_place`.
    """
    taken = take_places(seating_of(place, case), who, positions)
    return in_place(place, case, who, taken, heedless=heedless)


def in_place(
    place: Workplace, case: int, who: Occupants, taken: TakenPlaces, *, heedless: bool = False
) -> Situation:
    """People in the places that they have taken in a case, with the hands at rest.

    Parameters
    ----------
    heedless
        Whether the legs are left as they were predicted until `with_clear_legs`.
    """
    seated = taken.heedless or taken.seated
    taken = TakenPlaces(taken.poses if seated is None else seated.poses, seated, taken.stepped)
    shift = np.zeros((len(who), 3)) if seated is None else seated.shift
    spare = np.full((len(who), 2), np.nan) if seated is None else seated.spare_travel[:, :2]
    beside = tuple(one.in_case(case) for one in place.beside)
    male = who.people.sex[who.numbers] == sex_index("male")
    found = Situation(place, case, who.body, taken, taken.poses, shift, spare, male, beside)
    return found if heedless else with_clear_legs(found)


def with_clear_legs(situation: Situation) -> Situation:
    """The same, hands at rest, with the legs clear of what stands around where that was found: from
    where a prediction brought the feet to their pedals without regard to it. The hips stay."""
    place = situation.place
    seated = situation.seated
    if seated is None or situation.work.aims is None or situation.taken.heedless is not None:
        return situation
    found = clear_legs(
        situation.body,
        seated.poses,
        place.environment,
        {foot: seated.pitches.get(foot) for foot in seated.miss},
        sat_on=place.moving_parts,
    )
    clear = replace(seated, poses=found.poses, leg_overlap=found.overlap, leg_part=found.part)
    taken = TakenPlaces(found.poses, clear, situation.taken.stepped, seated)
    clear_of_parts = replace(situation, taken=taken, poses=found.poses)
    asked = [one for one in place.criteria if one.asks(situation.work.name)]
    if any(one.check == "self_contact" for one in asked) and _hands_of(situation):
        return _with_parted_knees(clear_of_parts)
    return clear_of_parts


def _with_parted_knees(situation: Situation) -> Situation:
    """The same, where the legs give way to the arms of people whose hands come to what they hold only
    with an arm in a leg: to those that then do by less."""
    rows = np.flatnonzero(in_own_legs(situation.body, situation.held.own) > 0.0)
    if not len(rows):
        return situation
    some = situation.rows(rows)
    seated = some.seated
    assert seated is not None
    legs = clear_legs(
        some.body,
        some.held.poses,
        situation.environment,
        {foot: seated.pitches.get(foot) for foot in seated.miss},
        sat_on=situation.place.moving_parts,
        arms=True,
    )
    turned = [joint for foot in seated.miss for joint in limb(some.body, foot).free]
    parted = _turned_as(some, turned, legs.poses.rotations)
    deep = (in_own_legs(some.body, one.held.own) for one in (parted, some))
    less = np.less(*deep)
    rotations = situation.poses.rotations.copy()
    rotations[rows[less]] = parted.poses.rotations[less]
    return _turned_as(situation, turned, rotations) if less.any() else situation


def _turned_as(situation: Situation, joints: Sequence[int], rotations: Floats) -> Situation:
    """A situation with the hands at rest, where people who sit have turned some joints as rotations
    (B, J, 4) say."""
    turned = situation.poses.rotations.copy()
    turned[:, joints] = rotations[:, joints]
    poses = replace(situation.poses, rotations=turned)
    seated = situation.seated
    assert seated is not None
    taken = replace(situation.taken, poses=poses, seated=replace(seated, poses=poses))
    return replace(situation, taken=taken, poses=poses)


def position_of(situation: Situation) -> Floats:
    """(B, 2) [m] where the seats stand, forward and up; how far people without a seat have stepped,
    forward and left."""
    seated = situation.seated
    if seated is None:
        return situation.taken.stepped.copy()
    return np.stack([seated.forward, seated.up], axis=1)


def with_hands(situation: Situation) -> Situation:
    """The same with the hands on the controls that they hold, each in the tightest harness zone
    that will do, clear of the surroundings and of bystanders. They are brought there once: rows of
    a situation have them there too."""
    return situation.held


def with_some_hands(
    situation: Situation, hands: Collection[str], *, brief: bool = False
) -> Situation:
    """The same, where `with_hands` brings some hands alone to the controls that they hold: for what
    does not depend on the others.

    Parameters
    ----------
    brief
        As of `reach`: then some are `unsure`.
    """
    found = replace(situation)
    found.__dict__["held"] = _hands_placed(situation, hands, brief=brief)
    return found


def _hands_placed(
    situation: Situation, hands: Collection[str] = HANDS, *, brief: bool = False
) -> Situation:
    for hand, control in _hands_of(situation):
        if hand in hands:
            situation = _with_hand(situation, hand, control, brief=brief)
    return situation


def _hands_of(situation: Situation) -> list[tuple[str, Control]]:
    """The hands that hold a control, in the order in which they are brought there."""
    controls = {control.name: control for control in situation.environment.controls}
    held = situation.work.held
    return [(hand, controls[name]) for hand, name in held.items() if hand in HANDS]


def _holding_arms(
    situation: Situation, hands: Collection[str] = HANDS, freest: int = max(ZONES)
) -> list[Limb]:
    """The arms whose hands hold a control, of some hands, in the freest zone of the control, or in
    `freest` where that is tighter."""
    return [
        limb(situation.body, hand, grip=control.grip, zone=min(situation.freest(control), freest))
        for hand, control in _hands_of(situation)
        if hand in hands
    ]


def hands_moved(situation: Situation, controls: Set[str]) -> tuple[str, ...]:
    """The hands that are elsewhere once some controls are: those that hold one, and those that hang
    on a joint that these turn."""
    found: list[str] = []
    for hand, control in _hands_of(situation):
        arm = limb(situation.body, hand, grip=control.grip, zone=situation.freest(control))
        turned = _turned_by(situation, _holding_arms(situation, found))
        bears = _beyond(situation.body, turned)[arm.base] or turned[list(arm.free)].any()
        if control.name in controls or bears:
            found.append(hand)
    return tuple(found)


def with_hands_again(situation: Situation, hands: Collection[str], before: Situation) -> Situation:
    """The same as `with_hands`, where only some hands are elsewhere than they were.

    Parameters
    ----------
    situation
        People with their hands at rest.
    hands
        Those that are brought to their controls anew, as of `hands_moved`.
    before
        The same people in the same place with all hands on their controls.
    """
    for hand, control in _hands_of(situation):
        if hand in hands:
            situation = _with_hand(situation, hand, control)
            continue
        zone = situation.freest(control)
        free = list(limb(situation.body, hand, grip=control.grip, zone=zone).free)
        poses = situation.poses
        rotations = poses.rotations.copy()
        rotations[:, free] = before.poses.rotations[:, free]
        situation = replace(
            situation,
            poses=Poses(rotations, poses.reference, poses.world_from_reference),
            hand_miss={**situation.hand_miss, hand: before.hand_miss[hand]},
            hand_overlap={**situation.hand_overlap, hand: before.hand_overlap[hand]},
            hand_limit={**situation.hand_limit, hand: before.hand_limit[hand]},
        )
    return situation


def moved_by_hands(situation: Situation, hands: Collection[str] = HANDS) -> Bools:
    """(S,) the spheres that are elsewhere with some hands on the controls that they hold: those
    beyond the joints that this turns, and those that share in the turns of these joints."""
    return moved_by(situation.body, _turned_by(situation, _holding_arms(situation, hands)))


def moved_by_legs(situation: Situation) -> Bools:
    """(S,) the spheres that the legs move that have their feet on pedals."""
    body = situation.body
    turned = np.zeros(len(body.joints), dtype=np.bool_)
    for foot in situation.seated.miss if situation.seated is not None else ():
        turned[list(limb(body, foot).free)] = True
    return moved_by(body, turned)


def _turned_by(situation: Situation, arms: Sequence[Limb]) -> Bools:
    """(J,) the joints that arms turn on the way to the controls that they hold."""
    turned = np.zeros(len(situation.body.joints), dtype=np.bool_)
    for arm in arms:
        turned[list(arm.free)] = True
    return turned


def solid_to_others(situation: Situation, *, hands_on: bool) -> Bools:
    """(S,) the spheres of the first person that the hands of others keep clear of.

    These are not the fingers of hands that hold controls, which bend around them. As long as hands
    rest that will hold controls, their arms do not count either: they are still to go elsewhere.

    Parameters
    ----------
    hands_on
        Whether the hands are on the controls already.
    """
    arms = _holding_arms(situation, freest=ARMS_ALONE)
    solid = np.ones(len(situation.body.sphere_segment), dtype=np.bool_)
    for arm in arms:
        solid &= arm.solid[0] | (situation.body.sphere_segment != arm.end)
    if arms and not hands_on:
        solid &= ~moved_by(situation.body, _turned_by(situation, arms))
    return solid


def as_bystander(situation: Situation) -> Bystander:
    """The first person of a situation as others find the person."""
    here = situation.placed.of_person(0, np.array([0]))
    solid = solid_to_others(situation, hands_on=bool(situation.hand_miss))
    return Bystander(situation.place.role, here, solid)


def moved_by(body: Body, turned: Bools) -> Bools:
    """(S,) the spheres that are elsewhere, seen from the root of the body, once some joints (J,)
    are turned: those beyond them, and those that share in their turns."""
    moved = _beyond(body, turned)
    shared = turned[body.blend_joint] & (body.blend_joint >= 0)
    twisted = turned[body.topology.twist_joint] & (body.topology.twist_joint >= 0)
    return (moved | twisted)[body.sphere_segment] | shared


def _beyond(body: Body, turned: Bools) -> Bools:
    """(N,) the segments beyond some joints (J,)."""
    found = np.zeros(len(body.segments), dtype=np.bool_)
    for n in range(1, len(body.segments)):
        found[n] = found[body.parent[n]] or turned[n - 1]  # joint n - 1 bears segment n
    return found


def _with_hand(
    situation: Situation, name: str, control: Control, *, brief: bool = False
) -> Situation:
    """The same with one hand on its control."""
    body = situation.body
    recall = None
    if situation.remembered is not None:
        key = situation.case, name
        recall = situation.remembered.recall(situation.place, key, [control])
    poses = situation.poses
    rotations = poses.rotations.copy()
    miss = np.zeros(len(situation))
    overlap = np.zeros(len(situation))
    limit = np.full(len(situation), "", dtype=object)
    unsure = np.zeros(len(situation), dtype=np.bool_)
    if situation.unsure is not None:
        unsure |= situation.unsure
    left = np.arange(len(situation))
    environment = situation.environment
    moving = np.isin(environment.parts, situation.place.moving_parts).astype(np.int64)
    own = tuple(environment.part_index(part) for part in control.own_parts)
    room = ObstacleScene(
        environment, moving, situation.displacement, situation.bystanders, held=own
    )
    at = situation.where([control])
    other_arm = bool(situation.hand_miss)  # it is on its control already
    for zone in range(1, situation.freest(control) + 1):
        arm = limb(body, name, grip=control.grip, zone=zone)
        found = reach(
            body,
            Poses(
                poses.rotations[left], poses.reference, poses.world_from_reference[left], None, left
            ),
            at[left],
            limb=arm,
            environment=environment,
            moving_parts=situation.place.moving_parts,
            displacement=situation.displacement[left],
            bystanders=situation.bystanders,
            tighter_zones=False,  # those who are left have missed in them
            brief=brief,
            recall=recall.rows(left) if recall is not None else None,
            thorough=False,
            other_arm=other_arm,
        )
        rotations[left] = found.poses.rotations
        got = np.flatnonzero(found.reached[:, 0])
        there = clear_fingers(
            body, found.poses.rows(got), arm, at[left[got], 0], room, other_arm=other_arm
        )
        rotations[left[got]] = there.rotations
        miss[left] = np.where(found.reached[:, 0], 0.0, found.miss[:, 0])
        overlap[left] = found.overlap[:, 0]
        limit[left] = [found.reason(row, 0) for row in range(len(left))]
        unsure[left] |= brief & (found.doubt[:, 0] == KEPT)
        left = left[~found.reached[:, 0]]
        if not len(left):
            break
    return replace(
        situation,
        unsure=unsure if brief else situation.unsure,
        poses=Poses(rotations, poses.reference, poses.world_from_reference),
        hand_miss={**situation.hand_miss, name: miss},
        hand_overlap={**situation.hand_overlap, name: overlap},
        hand_limit={**situation.hand_limit, name: tuple(limit.tolist())},
    )


def without_seat(place: Workplace) -> Environment:
    """The surroundings without the own seat: a thigh presses the cushion down, it does not stop
    there."""
    return without_parts(place.environment, place.moving_parts)


@lru_cache(maxsize=8)
def without_parts(environment: Environment, parts: tuple[str, ...]) -> Environment:
    """Surroundings without some parts, by name, once for each, so that they are indexed once."""
    gone = np.isin(environment.parts, parts)
    return replace(environment, hidden=environment.hidden | gone)
