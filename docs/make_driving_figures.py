"""Make the pictures of docs/driving.md: the compact car with a driver in it. Run from anywhere."""

from __future__ import annotations

from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

import workbench as wb
from workbench.body.scaling.measure import measure
from workbench.draw.camera import look_at
from workbench.draw.disks import disks
from workbench.draw.scene import Scene, SceneBody
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.model.driving import Driver, Package
from workbench.model.surroundings import move_parts
from workbench.posture.seating.driving import driving_posture

IMAGES = Path(__file__).resolve().parent / "images"
OPEN = ("left_*", "roof_*")  # what is taken off to see the driver


def driven(
    name: str, sex: str, *, seed: int | None = None
) -> tuple[wb.Poses, wb.Body, wb.Environment]:
    """The poses of a driver at the wheel, the body, and the car with the seat where it is
    wanted."""
    body = wb.load_body(name)
    car = wb.load_environment("compact_car")
    at = {control.name: control.at for control in car.controls} | dict(car.points)
    size = measure(body, ["stature", "sitting_height"])
    driver = Driver(
        sex, size["stature"], size["sitting_height"], float(body.mass.sum()) / size["stature"] ** 2
    )
    library = load_postures(posture_path(name), body)[0]
    found = driving_posture(
        body,
        posture_pose(body, library, "driving"),
        car.seat("driver"),
        drivers=[driver],
        package=Package(
            at["accelerator_heel"], at["accelerator"], at["wheel_centre"], at["driver_h_point"]
        ),
        feet={"right foot": at["accelerator"], "left foot": at["foot_rest"]},
        eye=at["low_eye"][2],
        seed=seed,
    )
    car = move_parts(car, car.seat("driver").moves, found.shift[0])
    poses = found.poses
    for side, control in (("left", "wheel_ten"), ("right", "wheel_two")):
        arm = wb.limb(body, f"{side} hand", grip="grasp", zone=2)
        poses = wb.reach(body, poses, at[control], limb=arm, environment=car).poses
    return poses, body, car


def drawn(
    car: wb.Environment, bodies: tuple[SceneBody, ...], eye: tuple[float, float, float], path: Path
) -> None:
    """One picture of the car, opened, and who is in it."""
    gone = [any(fnmatchcase(part, pattern) for pattern in OPEN) for part in car.parts]
    scene = Scene(
        bodies,
        replace(car, hidden=car.hidden | np.array(gone)),
        title="a driver in the compact car",
    )
    camera = look_at(eye, (0.28, 0.1, 0.52), width=1000, height=640, field=0.62)
    disks(scene, camera, mode="shaded").save(path)


def main() -> None:
    """Both pictures."""
    poses, man, car = driven("adult_male", "male")
    drawn(car, (SceneBody(wb.place(man, poses)),), (0.1, 3.2, 0.75), IMAGES / "car_side.png")
    drawn(car, (SceneBody(wb.place(man, poses)),), (-1.5, 2.3, 1.75), IMAGES / "car_behind.png")


if __name__ == "__main__":
    main()
