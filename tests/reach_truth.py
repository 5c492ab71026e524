"""How many reaches that are said to be kept by an obstacle are false, by environment, level of
detail and hand.

People are seated by the study of a place, and asked for every control of the hands with each hand
in turn, in the control's own zone. A reach is kept by an obstacle where it is missed with obstacles
and without them reached, or missed by less than 2 mm. An independent judge searches these, and a
tenth of those reached, which shows what it can find.
"""

from __future__ import annotations

import itertools
import shutil
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

import workbench as wb
from tests.conftest import ROOT, SHARED
from tests.crowds import Crowd, crowd_of
from tests.reach_judge import RESTARTS, Judge, Surroundings
from workbench.model.environment import Control

HANDS = ("left hand", "right hand")
NEARLY = 2e-3
"""[m] What is missed by less without obstacles is searched too."""
SHARE_OF_REACHED = 0.1
CLOSE = 0.012
"""[m] How close to a part the hand of a planted posture is."""
CLEAR = 1e-4
"""[m] How far at least."""
LEGAL = 1e-3
"""[rad] How far from its stops."""
SHIPPED = {
    "trainer": ROOT / "studies" / "trainer_accommodation.yaml",
    "compact_car": ROOT / "studies" / "car_driver.yaml",
}
"""The study that seats people in each of the project's own environments."""
DATA = Path(__file__).parent / "data"
RANGER_MORE = """points:
  floor: [480, 137, 393]
"""
RANGER_CONTROLS = """
  dash_left: {at: [633, 400, 1100], grip: push, zone: 2, part: Ranger}
  dash_middle: {at: [575, 0, 1100], grip: push, zone: 2, part: Ranger}
  dash_low: {at: [527, 200, 1000], grip: pinch, zone: 2, part: Ranger}
  dash_right: {at: [558, -200, 1100], grip: pinch, zone: 3, part: Ranger}
  glove_box: {at: [543, -400, 1000], grip: grasp, zone: 3, part: Ranger}
  dash_top: {at: [572, 200, 1150], grip: push, zone: 3, part: Ranger}
  wheel_top: {at: [390, 300, 1440], grip: grasp, zone: 1, part: Steering_Wheel}
"""
"""What is reached in the utility vehicle besides its few controls."""


@dataclass(frozen=True)
class RealPlace:
    """A real cockpit: its mesh among the shared inputs, and the study that seats people in it."""

    mesh: str
    environment: str
    study: str
    more_points: str = ""
    more_controls: str = ""


REAL = {
    "ranger": RealPlace(
        "polaris_ranger_ev/polaris.dae",
        "ranger_environment.yaml",
        "ranger_drivers.yaml",
        RANGER_MORE,
        RANGER_CONTROLS,
    ),
    "hybrid": RealPlace(
        "prius_cardemo/hybrid_body.obj", "hybrid_environment.yaml", "hybrid_drivers.yaml"
    ),
    "console": RealPlace(
        "gazebo_control_console/console.dae", "console_environment.yaml", "console_operators.yaml"
    ),
}

MESHES = {name: SHARED / "environments" / place.mesh for name, place in REAL.items()}
"""Where the meshes of real cockpits are."""


@dataclass(frozen=True)
class Row:
    """A reach that was judged."""

    place: str
    detail: str
    people: int
    person: int
    hand: str
    grip: str
    zone: int
    control: str
    target: tuple[float, float, float]
    """[m]"""
    free_miss: float
    """[m] without obstacles."""
    miss: float
    """[m] with them."""
    overlap: float
    """[m]"""
    part: str
    """The obstacle that is said to keep it."""
    attempt: int
    """The judge's attempt that found a way, -1 where none did."""
    refused: int
    """Ways that the package did not confirm."""
    seconds: float
    angles: dict[str, list[float]]
    """[deg] of the limb's joints in the way that was found: swing, swing, twist."""

    def __str__(self) -> str:
        return (
            f"person {self.person} of {self.people}, {self.hand}, {self.grip}, zone {self.zone}, "
            f"{self.control}: {1e3 * self.miss:.2f} mm missed, {1e3 * self.overlap:.2f} mm into "
            f"{self.part}; attempt {self.attempt}"
        )


@dataclass
class Tally:
    """What came out for one place, level of detail and hand."""

    place: str
    detail: str
    hand: str
    asked: int = 0
    reached: int = 0
    kept: int = 0
    """Said to be kept by an obstacle, or missed by less than 2 mm without any."""
    short: int = 0
    """Those of them that are missed without obstacles too."""
    judged: int = 0
    false: int = 0
    worst: float = 0.0
    """[m] the largest miss that is false."""
    tried: int = 0
    """Reached rows that the judge was given."""
    found: int = 0
    """Those of them that it found a way for."""
    rows: list[Row] = field(default_factory=list)

    def __str__(self) -> str:
        return (
            f"{self.place:12} {self.detail:7} {self.hand:11} {self.asked:6} asked, {self.reached:6} "
            f"reached, {self.kept:4} kept by an obstacle ({self.short} short without), "
            f"{self.judged:4} judged, {self.false:3} false, the worst by {1e3 * self.worst:.1f} mm; "
            f"judge finds {self.found} of {self.tried} reached"
        )


@dataclass(frozen=True, eq=False)
class Seats:
    """People in their places."""

    name: str
    detail: str
    body: wb.Body
    poses: wb.Poses
    displacement: np.ndarray
    environment: wb.Environment
    moving_parts: tuple[str, ...]
    surroundings: Surroundings

    def pose(self, person: int) -> wb.Poses:
        """The posture of one person, as of a body of one row."""
        rows = slice(person, person + 1)
        poses = self.poses
        return wb.Poses(poses.rotations[rows], poses.reference, poses.world_from_reference[rows])

    def judge(self, person: int, name: str, grip: str, zone: int) -> Judge:
        """The judge of one limb of one person."""
        one = self.body[np.array([person])]
        arm = wb.limb(one, name, grip=grip, zone=zone)
        pose = self.pose(person)
        shift = self.displacement[person]
        return Judge(one, arm, pose, self.surroundings, shift, heeds_body=True)


def study_of(name: str, folder: Path) -> Path:
    """The study that seats people in a place; a real one is put into a folder."""
    if name in SHIPPED:
        return SHIPPED[name]
    place = REAL[name]
    mesh = MESHES[name]
    inside = folder / name
    inside.mkdir(exist_ok=True)
    shutil.copyfile(mesh, inside / mesh.name)
    text = (DATA / place.environment).read_text(encoding="utf-8")
    text = text.replace("points:\n", place.more_points) if place.more_points else text
    text = text.rstrip("\n") + place.more_controls + "\n"
    (inside / "environment.yaml").write_text(text, encoding="utf-8")
    shutil.copyfile(DATA / place.study, folder / place.study)
    return folder / place.study


def seats_of(name: str, study: Path, detail: str, people: int) -> Seats:
    """Draw people, and seat them as a study does."""
    crowd = crowd_of(study)
    drawn = replace(crowd.study.roles[0], detail=detail)
    drawn = replace(drawn, population=replace(drawn.population, people=people))
    crowd = Crowd(replace(crowd.study, roles=(drawn,)))
    rows = np.arange(people)
    body = crowd.bodies[rows]
    situation = crowd.situations(body, rows)[0]
    poses = situation.taken.poses
    moving = tuple(situation.place.moving_parts)
    bases = wb.place(body, poses).world_from_segment[:, body.segment("UT"), :, 3]
    return Seats(
        name=name,
        detail=detail,
        body=body,
        poses=poses,
        displacement=situation.displacement,
        environment=situation.environment,
        moving_parts=moving,
        surroundings=Surroundings(
            situation.environment, moving, bases, float(body.radius.max()) + 2e-3
        ),
    )


@dataclass(frozen=True, eq=False)
class Asked:
    """The reaches of everybody for the controls of one grip and zone with one hand."""

    seats: Seats
    hand: str
    grip: str
    zone: int
    names: tuple[str, ...]
    targets: np.ndarray
    free: wb.Reach
    found: wb.Reach

    @property
    def kept(self) -> np.ndarray:
        """(B, T) what is said to be kept by an obstacle; what the own body keeps is none."""
        obstacle = self.found.part < len(self.found.parts)
        return np.asarray(~self.found.reached & obstacle & (self.free.miss < NEARLY))


def asked_of(seats: Seats, hand: str, deeper: float) -> Iterator[Asked]:
    """Ask everybody for all controls of the hands with one of them."""
    groups: dict[tuple[str, int], list[Control]] = {}
    for control in seats.environment.controls:
        if control.grip != "foot":
            groups.setdefault((control.grip, control.zone), []).append(control)
    for (grip, zone), controls in groups.items():
        arm = wb.limb(seats.body, hand, grip=grip, zone=zone)
        targets = np.array([control.at for control in controls]) + np.array([deeper, 0.0, 0.0])
        free = wb.reach(seats.body, seats.poses, targets, limb=arm)
        found = wb.reach(
            seats.body,
            seats.poses,
            targets,
            limb=arm,
            environment=seats.environment,
            moving_parts=seats.moving_parts,
            displacement=seats.displacement,
        )
        names = tuple(control.name for control in controls)
        yield Asked(seats, hand, grip, zone, names, targets, free, found)


def judged(asked: Asked, person: int, target: int, judge: Judge, restarts: int) -> Row:
    """Judge one reach."""
    begun = time.process_time()
    verdict = judge.judge(asked.targets[target], restarts=restarts)
    part = int(asked.found.part[person, target])
    body = asked.seats.body
    joints = asked.found.joints if verdict.attempt >= 0 else ()
    return Row(
        place=asked.seats.name,
        detail=asked.seats.detail,
        people=len(body),
        person=person,
        hand=asked.hand,
        grip=asked.grip,
        zone=asked.zone,
        control=asked.names[target],
        target=tuple(asked.targets[target].tolist()),
        free_miss=float(asked.free.miss[person, target]),
        miss=float(asked.found.miss[person, target]),
        overlap=float(asked.found.overlap[person, target]),
        part=asked.found.parts[part] if part >= 0 else "",
        attempt=verdict.attempt,
        refused=verdict.refused,
        seconds=time.process_time() - begun,
        angles={body.joints[j]: np.degrees(verdict.angles[j]).tolist() for j in joints},
    )


def planted(
    seats: Seats, *, each: int, seed: int, draws: int = 800
) -> Iterator[tuple[Judge, np.ndarray]]:
    """Targets (n, 3) that are known to be reached: the tips of legal clear postures whose hand is
    within 12 mm of a part; at most `each` for every person, hand and zone."""
    rng = np.random.default_rng(seed)
    for person, hand in itertools.product(range(len(seats.body)), HANDS):
        for grip, zone in (("push", 1), ("pinch", 2), ("grasp", 3)):
            judge = seats.judge(person, hand, grip, zone)
            low, high = judge.scene.low, judge.scene.high
            turns = rng.uniform(low, high, (draws, len(low)))
            angles = np.array([judge.angles_at(row) for row in turns])
            yield judge, _clear_tips(judge, angles)[:each]


def _clear_tips(judge: Judge, angles: np.ndarray) -> np.ndarray:
    """(n, 3) the tips of those postures (P, J, 3) that are legal, clear, and close to a part."""
    poses = judge.posed(angles)
    margin = wb.stops(judge.body, poses).margin[:, list(judge.arm.free)]
    legal = np.flatnonzero(margin.min(axis=1) > LEGAL)
    poses = wb.Poses(poses.rotations[legal], poses.reference, poses.world_from_reference[legal])
    window = [judge.body.segments[segment] for segment in judge.arm.moving]
    placed = wb.place(judge.body, poses, window=window)
    met = wb.contacts(placed, judge.room, margin=CLOSE)
    met = met.rows(judge.arm.solid[0, met.sphere])
    entering = met.pose[met.excess > -CLEAR]
    close = met.pose[(met.segment == judge.arm.end) & (met.excess > -CLOSE)]
    end = placed.world_from_segment[np.setdiff1d(close, entering), judge.arm.end]
    tips: np.ndarray = end[:, :, :3] @ judge.arm.tip[0] + end[:, :, 3]
    return tips


def tally_of(
    seats: Seats,
    hand: str,
    *,
    deeper: float = 0.0,
    most: int = 200,
    seed: int = 1,
    restarts: int = RESTARTS,
) -> Tally:
    """Ask everybody, and judge at most so many reaches that are said to be kept, drawn by a
    seed."""
    rng = np.random.default_rng(seed)
    tally = Tally(seats.name, seats.detail, hand)
    every = list(asked_of(seats, hand, deeper))
    kept = [(g, b, t) for g, asked in enumerate(every) for b, t in np.argwhere(asked.kept)]
    tally.asked = sum(asked.found.reached.size for asked in every)
    tally.reached = int(sum(asked.found.reached.sum() for asked in every))
    tally.kept = len(kept)
    tally.short = sum(not every[g].free.reached[b, t] for g, b, t in kept)
    chosen = {kept[i] for i in rng.permutation(len(kept))[:most]}
    tally.judged = len(chosen)
    reached = [(g, b, t) for g, one in enumerate(every) for b, t in np.argwhere(one.found.reached)]
    some = {row for row in reached if rng.random() < SHARE_OF_REACHED}
    judges: dict[tuple[int, int], Judge] = {}
    for g, b, t in sorted(chosen | some):
        asked = every[g]
        if (g, b) not in judges:
            judges[g, b] = seats.judge(int(b), hand, asked.grip, asked.zone)
        row = judged(asked, int(b), int(t), judges[g, b], restarts)
        if (g, b, t) in some:
            tally.tried += 1
            tally.found += row.attempt >= 0
            continue
        tally.rows.append(row)
        if row.attempt >= 0:
            tally.false += 1
            tally.worst = max(tally.worst, row.miss + row.overlap)
    return tally
