"""Predicted postures: the seat where it gives view and pedals, feet on the pedals, hands on the
controls; drivers by the statistical posture."""

from __future__ import annotations

from dataclasses import replace

from workbench.body.forward import place
from workbench.model.environment import Control, Environment, Seat
from workbench.model.poses import Poses
from workbench.model.posing import join_poses
from workbench.model.posture_study import Aims, Person, PostureStudy, SeatFit
from workbench.posture.reaching.limbs import limb
from workbench.posture.reaching.reach import reach
from workbench.posture.seating.driving import DrivingPosture, driving_posture
from workbench.posture.seating.posture import Pedals
from workbench.posture.seating.seat import Seated, seat
from workbench.study.accommodation.drivers import driver_of, feet_of, package_of
from workbench.study.own_position import own_position
from workbench.study.persons import sized
from workbench.study.placement import adjusted_environment

__all__ = ["predicted", "prepared"]

TOLD = 1e-3
"""A miss [m] that is told."""


def prepared(study: PostureStudy) -> tuple[PostureStudy, list[str]]:
    """The study as a run measures it and as pictures show it: bodies at their size, predicted
    postures found; and in words what is improbable about the sizes and what could not be had."""
    study, told = sized(study)
    study, short = predicted(study)
    return study, [*told, *short]


def predicted(study: PostureStudy) -> tuple[PostureStudy, list[str]]:
    """The study with every posture that is to be predicted found, and in words what could not be
    had."""
    told: list[str] = []
    if not any(aims for person in study.people for aims in person.aims):
        return study, told
    people: list[Person] = []
    sitting = []
    for number, person in enumerate(study.people):
        # a later one heeds where those before have put their seats
        environment = adjusted_environment(replace(study, people=tuple(people)))
        found, words = _seat(person, study, number, environment)
        people.append(found[0])
        sitting.append(found[1])
        told += words
    seated = replace(study, people=tuple(people))
    environment = adjusted_environment(seated)
    done = []
    for person, rows in zip(people, sitting, strict=True):
        poses = []
        for case, (aims, row) in enumerate(zip(person.aims, rows, strict=True)):
            if aims is None or row is None:
                poses.append(_one(person.poses, case))
                continue
            held, words = _hands(person, (row, aims), environment)
            told += [f"{person.name}, {study.cases[case]}: {line}" for line in words]
            at = person.poses.reference
            world = person.poses.world_from_reference[:1]
            if (
                aims.driving is not None
            ):  # who is where the poses say, not where the seat's planes do
                world = place(person.body, held).world_from_segment[:, at]
            poses.append(Poses(held.rotations, at, world))
        driving = tuple(aims is not None and aims.driving is not None for aims in person.aims)
        done.append(replace(person, poses=join_poses(poses), held=driving if any(driving) else ()))
    return replace(seated, people=tuple(done)), told


def _one(poses: Poses, case: int) -> Poses:
    return Poses(
        poses.rotations[case : case + 1],
        poses.reference,
        poses.world_from_reference[case : case + 1],
    )


def _seat(
    person: Person, study: PostureStudy, number: int, environment: Environment
) -> tuple[tuple[Person, list[Poses | None]], list[str]]:
    """The person with the seat where it is to be, and for each predicted case the posture with the
    feet placed; a driver's is drawn by the person's number."""
    rows: list[Poses | None] = []
    fits: list[SeatFit | None] = []
    told: list[str] = []
    settled = not person.free_seat
    for case, aims in enumerate(person.aims):
        if aims is None or person.seat is None:
            rows.append(None)
            fits.append(None)
            continue
        stands = study.environment.seat(person.seat)
        pedals = _pedals(aims, study.environment)
        wanted = study.environment.points[aims.eyes][2] if aims.eyes else None
        pose = _one(person.poses, case)
        if aims.driving is not None:
            driven = _driven((person, number), (aims, pose), study.environment, settled)
            person = replace(person, forward=float(driven.forward[0]), up=float(driven.up[0]))
            settled = True
            rows.append(driven.poses)
            fits.append(_driver_fit(driven, stands))
            told += [
                f"{person.name}, {study.cases[case]}: {line}" for line in _off(driven, aims, wanted)
            ]
            continue
        if settled:
            stands = stands.held(person.forward, person.up)
        found = seat(person.body, pose, stands, eye=wanted, pedals=pedals)
        spare = float(found.spare_travel[0, :2].min())
        if not settled:
            person = replace(person, forward=float(found.forward[0]), up=float(found.up[0]))
            person, words = own_position(study, person, case, environment)
            if words:
                told.append(f"{person.name}, {study.cases[case]}: {words}")
                stands = stands.held(person.forward, person.up)
                found = seat(person.body, pose, stands, eye=wanted, pedals=pedals)
        settled = True
        rows.append(found.poses)
        fits.append(_fit(found, spare))
        told += [
            f"{person.name}, {study.cases[case]}: {line}" for line in _short(found, aims, wanted)
        ]
    return (replace(person, fits=tuple(fits)), rows), told


def _driver_fit(found: DrivingPosture, stands: Seat) -> SeatFit:
    """How seat and pedals came out for a driver, who wants the seat at one place."""
    rear, front = stands.travel_forward
    wanted = float(found.wanted[0])
    return _fit(found, min(wanted - rear, front - wanted))


def _fit(found: Seated, spare: float) -> SeatFit:
    foot = max(found.miss, key=lambda name: float(found.miss[name][0]), default="")
    if not foot:
        return SeatFit(0.0, "", "", spare)
    return SeatFit(float(found.miss[foot][0]), foot, found.limit[foot][0], spare)


def _driven(
    who: tuple[Person, int], what: tuple[Aims, Poses], environment: Environment, settled: bool
) -> DrivingPosture:
    """A driver's posture, in the seat where it stands already or where the driver puts it."""
    (person, number), (aims, pose) = who, what
    assert aims.driving is not None
    stands = environment.seat(person.seat or "")
    return driving_posture(
        person.body,
        pose,
        stands.held(person.forward, person.up) if settled else stands,
        drivers=[driver_of(person, aims.driving)],
        package=package_of(aims, environment),
        feet=feet_of(aims, environment),
        eye=environment.points[aims.eyes][2] if aims.eyes else None,
        seed=aims.driving.seed,
        numbers=[number],
    )


def _off(found: DrivingPosture, aims: Aims, wanted: float | None) -> list[str]:
    """What the seat and the feet of a driver could not give."""
    told = []
    if wanted is not None and wanted - found.eye[0, 2] > TOLD:
        below = 1000 * (wanted - found.eye[0, 2])
        told.append(
            f"the eyes stay {below:.0f} mm below {aims.eyes}, the seat is as high as it goes"
        )
    beyond = float(found.wanted[0] - found.forward[0])
    if abs(beyond) > TOLD:
        way = "forward" if beyond > 0 else "back"
        told.append(
            f"the seat would go {1000 * abs(beyond):.0f} mm farther {way} than its travel lets it"
        )
    return told + _feet_off(found, aims)


def _feet_off(found: Seated, aims: Aims) -> list[str]:
    """What feet stay from their pedals."""
    told = []
    for foot, miss in found.miss.items():
        if miss[0] > TOLD:
            what = f"the {foot} stays {1000 * miss[0]:.0f} mm from {aims.controls[foot]}"
            told.append(f"{what}, limited by {found.limit[foot][0]}")
    return told


def _pedals(aims: Aims, environment: Environment) -> Pedals:
    controls = {control.name: control for control in environment.controls}
    at = {name: controls[held].at for name, held in aims.controls.items() if name.endswith("foot")}
    return Pedals(at, environment.points[aims.heels][2] if aims.heels else None)


def _short(found: Seated, aims: Aims, wanted: float | None) -> list[str]:
    """What the seat and the feet could not give."""
    told = []
    if wanted is not None and wanted - found.eye[0, 2] > TOLD:
        below = 1000 * (wanted - found.eye[0, 2])
        told.append(
            f"the eyes stay {below:.0f} mm below {aims.eyes}, the seat is as high as it goes"
        )
    if wanted is not None and found.eye[0, 2] - wanted > TOLD:
        above = 1000 * (found.eye[0, 2] - wanted)
        told.append(f"the eyes are {above:.0f} mm above {aims.eyes}, the seat is as low as it goes")
    return told + _feet_off(found, aims)


def _hands(
    person: Person, case: tuple[Poses, Aims], environment: Environment
) -> tuple[Poses, list[str]]:
    """The hands on their controls, each in the tightest harness zone that will do."""
    poses, aims = case
    controls = {control.name: control for control in environment.controls}
    told = []
    for name, held in aims.controls.items():
        if not name.endswith("hand"):
            continue
        control: Control = controls[held]
        for zone in range(1, control.zone + 1):
            chain = limb(person.body, name, grip=control.grip, zone=zone)
            found = reach(person.body, poses, control.at, limb=chain, environment=environment)
            if found.reached[0, 0]:
                break
        poses = found.poses
        if not found.reached[0, 0]:
            told.append(
                f"the {name} stays {1000 * found.miss[0, 0]:.0f} mm from {held}, "
                f"limited by {found.limit(0, 0)}"
            )
    return poses, told
