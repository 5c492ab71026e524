"""The smallest complete study: one arm in a box of a cab, written as files into a folder."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from pathlib import Path

from tests.conftest import BOX, BOX_FACES, ONE_ARM

IN_PIECES = (
    "anna, bert: the body is in 7 pieces with gaps of up to 60 mm (upper arm, lower arm, hand); "
    "thin parts between them touch nothing"
)
"""What every run of the study warns of: the spheres of the arm stand far apart."""
POSITION = re.compile(r"[^:]+\.yaml:(\d+):(\d+): ")

POSTURES = """reference: BASE
postures:
  hanging: {description: the arm straight down}
  bent:
    description: elbow bent to a right angle
    angles:
      ELBOW: {flexion: 90}
"""
ENVIRONMENT = """environment: cab
length: mm
accepted: [floor of seat stool]
meshes:
  - {file: cab.obj, length: m, up: z, forward: x}
parts:
  secret: {hidden: true}
  rest: {allow: [{segments: [BASE], depth: 20}]}
  seat: {allow: [{segments: all, depth: 400}]}
seats:
  stool:
    srp: [0, 0, 0]
    back_angle: 0
    cushion_angle: 0
    cushion: {part: seat, segments: [BASE], depth: 10}
    back: {part: rest, segments: [BASE], depth: 10}
    travel: {forward: [-50, 50], up: [-20, 20]}
    moves: [seat, rest]
"""
STUDY = """study: cab_study
title: One arm in a cab
length: mm
environment: cab
people:
  anna: {body: one_arm, seat: stool, position: {forward: 10, up: 0}}
  bert: {body: one_arm, at: {segment: BASE, position: [0, 600, 900], attitude: {yaw: 90}}}
cases:
  - name: down
    people:
      anna: {posture: hanging}
      bert: {posture: hanging}
  - name: forward
    people:
      anna: {posture: bent, angles: {SHOULDER: {flexion: 80}}}
      bert: {posture: bent}
criteria:
  - {name: nobody is in the cab, check: contact}
  - {name: room for the hand, check: clearance, people: [anna], segments: [HAND], parts: ["w*"], at_least: 100}
  - {name: nobody is in himself, check: self_contact}
  - {name: nobody is in another, check: between_people, at_least: 0}
  - {name: joints, check: stops, at_least: 0}
"""
PARTS = {
    "floor": ((-1, -1, -1), (1, 1, -0.9)),
    "wall": ((0.6, -1, -0.9), (0.65, 1, 0.5)),
    "seat": ((-0.2, -0.2, -0.06), (0.2, 0.2, 0)),
    "rest": ((-0.06, -0.2, 0), (0, 0.2, 0.3)),
    "secret": ((-1, 0.9, 0), (-0.9, 1, 0.1)),
}


def write_cab(
    folder: Path,
    *,
    study: str = STUDY,
    body: str = ONE_ARM,
    postures: str = POSTURES,
    environment: str = ENVIRONMENT,
) -> Path:
    """Write body, postures, environment and study as a catalogue; returns the study's file."""
    for kind in ("bodies", "environments/cab", "studies"):
        (folder / kind).mkdir(parents=True, exist_ok=True)
    (folder / "bodies/one_arm.yaml").write_text(
        body.replace("length: mm", "length: mm\npostures: arms.yaml", 1)
    )
    (folder / "bodies/arms.yaml").write_text(postures)
    (folder / "environments/cab/cab.obj").write_text(boxes(PARTS))
    (folder / "environments/cab/environment.yaml").write_text(environment)
    path = folder / "studies/cab_study.yaml"
    path.write_text(study)
    return path


def boxes(parts: dict[str, tuple[tuple[float, ...], tuple[float, ...]]]) -> str:
    """An OBJ file of boxes from least to greatest corner [m]."""
    lines: list[str] = []
    for n, (name, (low, high)) in enumerate(parts.items()):
        lines.append(f"o {name}")
        lines += [
            "v {} {} {}".format(*(low[k] + corner[k] * (high[k] - low[k]) for k in range(3)))
            for corner in BOX
        ]
        lines += ["f {} {} {}".format(*(face + 1 + 8 * n)) for face in BOX_FACES]
    return "\n".join(lines) + "\n"


def changed(text: str, old: str, new: str) -> str:
    """The text with one place changed, which must be there."""
    assert old in text, old
    return text.replace(old, new, 1)


def lines_of(problems: tuple[str, ...]) -> list[int]:
    """The line of each problem; every one must carry file, line and column."""
    found = [POSITION.match(problem) for problem in problems]
    assert all(found), problems
    return [int(match[1]) for match in found if match]


def line_with(text: str, part: str) -> int:
    """The number of the first line that holds this part."""
    return next(n for n, line in enumerate(text.splitlines(), start=1) if part in line)


def mutants(text: str, count: int, *, seed: int) -> Iterator[bytes]:
    """Copies of a text with bytes flipped, lines doubled, dropped or exchanged, numbers and names
    replaced."""
    rng = random.Random(seed)
    odd = [b"-1", b".nan", b"1e308", b"", b"[]", b"null", b"0x" + b"f" * 300, b"x", b"*a", b"\xff"]
    for _ in range(count):
        lines = text.encode().split(b"\n")
        kind = rng.randrange(6)
        a = rng.randrange(len(lines))
        b = rng.randrange(len(lines))
        if kind == 0:
            lines = lines[:a]
        elif kind == 1:
            lines.insert(a, lines[b])
        elif kind == 2:
            lines[a], lines[b] = lines[b], lines[a]
        elif kind == 3:
            lines[a] = lines[a][1:] if lines[a][:1] == b" " else b" " + lines[a]
        else:
            words = list(re.finditer(rb"-?[\d.]+" if kind == 4 else rb"\w+|[\[\]{}:,]", lines[a]))
            if words:
                word = rng.choice(words)
                lines[a] = lines[a][: word.start()] + rng.choice(odd) + lines[a][word.end() :]
        yield b"\n".join(lines)
