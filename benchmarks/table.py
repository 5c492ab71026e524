"""Rows of figures, the goals that stand beside them, and the page that they make."""

from __future__ import annotations

import datetime
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

__all__ = ["GOALS", "LIBRARIES", "Goal", "Row", "Section", "machine", "page", "sections_of"]

LIBRARIES = ("warp-lang", "fcpw", "open3d", "libigl", "python-fcl", "coal", "mujoco")
"""Other libraries that figures are compared with, as they are called where they are installed."""


@dataclass(frozen=True)
class Goal:
    """What a figure should be: at most so much, or at least."""

    value: float
    at_least: bool = False

    def met(self, value: float) -> bool:
        """Whether a value is as good as that; no value is not."""
        return value >= self.value if self.at_least else value <= self.value


GOALS = {
    ("by segment, permitted contact", "trainer, 957 spheres"): Goal(60),
    ("any", "trainer, 957 spheres"): Goal(10),
    ("by segment and part, with names", "trainer, 957 spheres"): Goal(300),
    ("by segment", "flat 50k, 1500 spheres"): Goal(30),
    ("any", "flat 50k, 1500 spheres"): Goal(3),
    ("growth by segment, 2k to 500k", "flat, 1500 spheres"): Goal(1.7),
    ("growth by segment, 2k to 500k", "curved, 1500 spheres"): Goal(1.6),
    ("by segment, Warp against ours", "flat 50k, 1500 spheres"): Goal(15, at_least=True),
    ("any, Warp against ours", "flat 50k, 1500 spheres"): Goal(10, at_least=True),
    ("clearance of all parts, one pose", "trainer, 957 spheres"): Goal(1),
    ("index made", "curved 50k"): Goal(0.6),
    ("index made", "flat 50k"): Goal(0.6),
    ("index made", "curved 500k"): Goal(4),
    ("index made", "flat 500k"): Goal(4),
    ("one position of the seat", "6068 people"): Goal(8),
    ("bodies, the first time", "6068 people"): Goal(15),
    ("the whole travel of the seat", "6068 people"): Goal(40),
    ("reach map of 2000 points", "6068 people"): Goal(45),
    ("a person of a population", "trainer_accommodation"): Goal(25),
    ("a person of a population", "car_driver"): Goal(35),
    ("a person of a population", "light aircraft"): Goal(300),
    ("a person of a population", "control console"): Goal(600),
    ("a person of a population", "hybrid car"): Goal(600),
    ("a person of a population", "utility vehicle"): Goal(600),
    ("a person of a population", "wheelchair"): Goal(600),
    ("one man", "light aircraft"): Goal(4),
    ("first run less a warm one", "trainer_clearance"): Goal(8),
    ("first run less a warm one", "trainer_reach"): Goal(18),
    ("first run less a warm one", "trainer_accommodation, 32 people"): Goal(16),
    ("first run less a warm one", "car_driver, 32 people"): Goal(14),
    ("warm", "trainer_clearance"): Goal(2.2),
    ("warm", "trainer_reach"): Goal(4.5),
    ("time, in one call", "1000000 poses in the trainer"): Goal(60),
    ("memory, in one call", "1000000 poses in the trainer"): Goal(2),
    ("any, on a graphics card", "1000000 poses, 50k, 1500 spheres"): Goal(0.1),
    ("by segment, on a graphics card", "1000000 poses, 50k, 1500 spheres"): Goal(1),
}
"""By figure and case, in the unit of the row."""


@dataclass(frozen=True)
class Row:
    """A figure of a case.

    Parameters
    ----------
    value
        The figure; None where it cannot be had, for the reason in `note`.
    unit
        Of the value.
    note
        What else is to be known.
    """

    figure: str
    case: str
    value: float | None
    unit: str
    note: str = ""

    @property
    def goal(self) -> Goal | None:
        """What the figure should be, None where nothing is stated."""
        return GOALS.get((self.figure, self.case))

    @property
    def missed(self) -> bool:
        """Whether there is a goal and the figure is not as good."""
        goal = self.goal
        return goal is not None and (self.value is None or not goal.met(self.value))

    @property
    def verdict(self) -> str:
        """The goal, and whether it is met; "" where there is none."""
        goal = self.goal
        if goal is None:
            return ""
        bound = "at least" if goal.at_least else "at most"
        return f"{bound} {goal.value:g} / {'missed' if self.missed else 'met'}"

    def __str__(self) -> str:
        value = "none" if self.value is None else f"{self.value:.3g} {self.unit}"
        return f"| {self.figure} | {self.case} | {value} | {self.verdict} | {self.note} |"


_HEAD = "| figure | case | | goal | |\n|---|---|---|---|---|"


@dataclass(frozen=True)
class Section:
    """Rows under a title, with words on how they were taken, and when and where."""

    title: str
    words: str
    rows: Sequence[Row]
    taken: str = ""

    def __str__(self) -> str:
        head = [f"## {self.title}", self.words, "", *([f"{self.taken}.", ""] if self.taken else [])]
        return "\n".join([*head, _HEAD, *map(str, self.rows)])


def sections_of(text: str) -> list[Section]:
    """Read the sections of a page back."""
    found = []
    for part in text.split("\n## ")[1:]:
        head, table = part.split(f"\n\n{_HEAD}\n")
        title, words, *taken = [line for line in head.split("\n") if line]
        rows = [_row_of(line) for line in table.strip().split("\n")]
        found.append(Section(title, words, rows, "".join(taken).removesuffix(".")))
    return found


def _row_of(line: str) -> Row:
    """Read a row of a table back; the figure with the digits that are there."""
    figure, case, value, _, note = line.removeprefix("| ").removesuffix(" |").split(" | ")
    number, _, unit = value.partition(" ")
    return Row(figure, case, None if number == "none" else float(number), unit, note)


def page(sections: Sequence[Section], *, whole: bool = True) -> str:
    """Return the page of some sections: what is not met, and the figures.

    whole: whether these are all, so that a goal without a figure is one that nothing was taken for.
    """
    rows = [row for section in sections for row in section.rows]
    judged = [row for row in rows if row.goal is not None]
    missed = [row for row in judged if row.missed]
    lines = ["# Benchmarks", ""]
    lines += ["Made by `python -m benchmarks --write`; each section says when it was taken.", ""]
    lines.append(f"{len(judged) - len(missed)} of {len(judged)} goals are met.")
    if missed:
        lines += ["", "Not met:", ""]
    for row in missed:
        value = f"none ({row.note})" if row.value is None else f"{row.value:.3g} {row.unit}"
        bound = row.verdict.removesuffix(" / missed")
        lines.append(f"- {row.figure}, {row.case}: {value}; {bound} was aimed at")
    taken = {(row.figure, row.case) for row in rows}
    idle = [", ".join(key) for key in GOALS if whole and key not in taken]
    if idle:
        lines += ["", f"No figure was taken for: {'; '.join(idle)}."]
    return "\n".join([*lines, *(f"\n{section}" for section in sections), ""])


def machine() -> str:
    """Return where and with what the figures were taken."""
    found = {d.metadata["Name"].lower(): d.version for d in metadata.distributions()}
    libraries = ("numpy", "numba", *LIBRARIES)
    versions = ", ".join(f"{name} {found[name]}" for name in libraries if name in found)
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    models = (line.split(": ")[1] for line in lines if line.startswith("model name"))
    model = next(models, platform.processor())
    python = f"Python {platform.python_version()}, {versions}"
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    return (
        f"{datetime.date.today()}, {model}, {os.cpu_count()} cores, load {load:.1f} at the end, "
        f"{python}"
    )
