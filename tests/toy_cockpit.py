"""A cockpit of a few boxes, quick to sit in: a seat, a panel and a post far from everybody, knobs
in the air."""

from __future__ import annotations

from tests.conftest import BOX, BOX_FACES

# name, least and greatest corner [mm]: the SRP is the seat's edge at (0, 0, 300)
BOXES = {
    "pan": ([-50, -250, 200], [450, 250, 300]),
    "back": ([-100, -250, 300], [0, 250, 900]),
    "panel": ([1500, -300, 600], [1520, 300, 900]),
    "roof": ([-500, -500, 1600], [500, 500, 1620]),
}
ENVIRONMENT = """
environment: toy
length: mm
accepted: ["floor of seat *"]
meshes: [{file: toy.obj, length: mm, up: z, forward: x}]
parts:
  pan: {allow: [{segments: [all], depth: 200}]}
  back: {allow: [{segments: [all], depth: 200}]}
seats:
  pilot:
    srp: [0, 0, 300]
    back_angle: 0
    cushion_angle: 0
    yaw: 0
    cushion: {part: pan, segments: [LT], depth: 10}
    back: {part: back, segments: [LT, UT], depth: 10}
    travel: {forward: [0, 0], up: [0, 0]}
    moves: [pan, back]
points:
  eye: [100, 0, 1050]
controls:
  knob: {at: [KNOB, -180, 850], grip: push, zone: 1, part: panel}
  near: {at: [450, -200, 800], grip: push, zone: 1, part: panel}
"""
STUDY = """
study: toy_crew
length: mm
environment: toy
people:
  pilot: {body: adult_male, detail: coarse, seat: pilot, population: {people: PEOPLE, seed: 3}}
cases:
  - {name: sitting, people: {pilot: {predicted: {like: driving, eyes: eye}}}}
criteria:
  - {name: knobs, check: reach, controls: [knob, near], hand: right}
  - {name: view, check: eye_height, below: 60, above: 60}
  - {name: head room, check: clearance, segments: [H], parts: [roof], at_least: 150}
"""

__all__ = ["BOXES", "write_toy"]


def write_toy(folder, *, knob=700, people=10, study=STUDY, **changes):
    """Write the cockpit and the study into a folder; returns the study's path. changes: text to put
    for text, and more boxes."""
    place = folder / "environments" / "toy"
    place.mkdir(parents=True, exist_ok=True)
    (place / "toy.obj").write_text(_obj(BOXES | changes.get("boxes", {})))
    (place / "environment.yaml").write_text(ENVIRONMENT.replace("KNOB", f"{knob:.4f}"))
    (folder / "studies").mkdir(exist_ok=True)
    text = study.replace("PEOPLE", str(people))
    for old, new in changes.get("swap", {}).items():
        assert old in text, old
        text = text.replace(old, new)
    path = folder / "studies" / "toy_crew.yaml"
    path.write_text(text)
    return path


def _obj(boxes):
    lines = []
    count = 1
    for name, (low, high) in boxes.items():
        lines.append(f"o {name}")
        for x, y, z in BOX:
            corner = [a + t * (b - a) for a, b, t in zip(low, high, (x, y, z), strict=True)]
            lines.append("v " + " ".join(f"{value:g}" for value in corner))
        lines += [f"f {a + count} {b + count} {c + count}" for a, b, c in BOX_FACES.tolist()]
        count += 8
    return "\n".join(lines) + "\n"
