"""What is asked about: people seated in the product's places, cockpits of curved and of flat faces,
and a real vehicle.

Seated people are in permitted contact with solid parts, as in every study; the poses are seeded and
lie around the posture of the study.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import workbench as wb
from benchmarks.workload import cockpit, dense_body, flat_cockpit, seated_poses
from tests.reach_truth import MESHES, study_of
from workbench.contact.collide import allowed_groups
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Placed, Poses
from workbench.model.quaternions import multiply
from workbench.model.study import Study
from workbench.study.people import present_people

__all__ = [
    "BODIES",
    "Case",
    "changed_study",
    "in_cockpit",
    "in_real_vehicle",
    "opened",
    "seated_in",
    "study_file",
]

STUDIES = Path(__file__).parents[1] / "studies"
POSES = 1000
BODIES = {
    "399": ("bubbleman", None),
    "409": ("adult_male", "medium"),
    "957": ("adult_male", "fine"),
    "1500": ("adult_male", "fine"),
}
"""Bodies and their levels of detail by how many spheres they have; the last is made denser."""
REAL = "ranger"
"""The utility vehicle, which is looked for among the shared inputs."""
LIMBER = {"S", "E", "W"}
"""Joints that are turned most: shoulders, elbows, wrists."""


@dataclass(frozen=True, eq=False)
class Case:
    """A body in many poses in an environment."""

    name: str
    poses: Poses
    placed: Placed
    environment: Environment

    @property
    def groups(self) -> tuple[tuple[int, ...], ...]:
        """Parts that every segment may be equally deep in."""
        return allowed_groups(self.placed.body, self.environment)[0]

    @property
    def allowed(self) -> Floats:
        """(N, G) [m] how deep each segment may be in each group."""
        return allowed_groups(self.placed.body, self.environment)[1]

    def few(self, rows: slice | Ints) -> Case:
        """The case with some of the poses."""
        placed = self.placed
        some = Placed(
            placed.body, placed.world_from_segment[rows], placed.centres[rows], placed.window
        )
        return replace(self, poses=self.poses.rows(rows), placed=some)


def study_file(name: str, change: Callable[[dict[str, Any]], None], folder: Path) -> Path:
    """Write one of the project's studies with something changed into a folder."""
    document = yaml.safe_load((STUDIES / f"{name}.yaml").read_text(encoding="utf-8"))
    change(document)
    path = folder / f"{name}.yaml"
    path.write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")
    return path


def changed_study(name: str, change: Callable[[dict[str, Any]], None]) -> Study:
    """Load one of the project's studies with something changed."""
    with tempfile.TemporaryDirectory() as folder:
        return wb.load_study(study_file(name, change, Path(folder)))


def seated_in(place: str, spheres: str, poses: int = POSES) -> Case:
    """Seat a body of BODIES in the trainer, as its README's study has the pilot, or behind the wheel
    of the compact car."""
    body, pose, environment = _seat_of(place, BODIES[spheres])
    if spheres == "1500":
        body = dense_body(body)
    return _case(f"{place}, {spheres} spheres", body, _around(body, pose, poses), environment)


@cache
def _seat_of(place: str, who: tuple[str, str | None]) -> tuple[Body, Poses, Environment]:
    """Who sits there, in the one posture of the study."""
    name, detail = who
    role = {"body": name} | ({"detail": detail} if detail else {})
    if place == "trainer":
        study = changed_study("trainer_clearance", lambda document: _fly(document, role))
    else:
        study = changed_study("car_driver", lambda document: _drive(document, role))
    there = present_people(study)
    situation = there.situations[0][0]
    return situation.body, situation.poses, there.environment


def _fly(document: dict[str, Any], role: dict[str, str]) -> None:
    document["people"]["pilot"] |= role


def _drive(document: dict[str, Any], role: dict[str, str]) -> None:
    del document["shares"], document["changes"]
    driver = document["people"]["driver"]
    del driver["population"], driver["clothes"]  # shoes would be spheres too
    driver |= role
    document["cases"][0]["people"]["driver"]["driver"]["sex"] = "male"


def in_cockpit(kind: str, size: str, spheres: str, poses: int = POSES) -> Case:
    """Put a body into a made cockpit of curved or of flat faces, in poses around a seated one."""
    body = wb.load_body("bubbleman")
    if spheres != "399":
        body = dense_body(body, int(spheres))
    environment = cockpit(size) if kind == "curved" else flat_cockpit(size)
    return _case(
        f"{kind} {size}, {spheres} spheres",
        body,
        seated_poses(body, poses, spread=1.15),
        environment,
    )


def in_real_vehicle(spheres: str, poses: int = POSES) -> Case | None:
    """Seat a body in the utility vehicle; None where its mesh is not there."""
    if not MESHES[REAL].exists():
        return None
    with tempfile.TemporaryDirectory() as folder:
        environment = wb.load_study(study_of(REAL, Path(folder))).environment
    name = BODIES[spheres][0]
    body = wb.load_body(name)
    path = posture_path(name)
    assert path is not None
    pose = posture_pose(body, load_postures(path, body)[0], "driving")
    seat = environment.seats[0]
    seated = wb.seat(body, pose, seat.held(0.0, 0.0)).poses
    return _case(f"{REAL}, {spheres} spheres", body, _around(body, seated, poses), environment)


def opened(case: Case) -> Case:
    """The case with no part solid and nothing permitted, which is all that other libraries know."""
    environment = replace(
        case.environment, solid=np.zeros_like(case.environment.solid), allowances=()
    )
    return replace(case, environment=environment)


def _case(name: str, body: Body, poses: Poses, environment: Environment) -> Case:
    return Case(name, poses, wb.place(body, poses), environment)


def _around(body: Body, pose: Poses, count: int, *, seed: int = 7) -> Poses:
    """Poses around one: arms move freely, all else a little, and the body by some millimetres in
    its seat."""
    rng = np.random.default_rng(seed)
    loose = [name[0] in "LR" and name[1:] in LIMBER for name in body.joints]
    angle = np.where(loose, 0.2, 0.03)[:, None]
    turn = np.ones((count, len(body.joints), 4))
    turn[..., 1:] = 0.5 * angle * rng.normal(size=(count, len(body.joints), 3))
    turn /= np.linalg.norm(turn, axis=-1, keepdims=True)
    world = np.repeat(pose.world_from_reference, count, axis=0)
    world[:, :, 3] += rng.normal(size=(count, 3)) * [0.004, 0.003, 0.003]
    return Poses(multiply(pose.rotations, turn), pose.reference, world)
