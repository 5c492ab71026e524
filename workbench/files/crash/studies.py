"""Crash studies: everything they name is loaded and checked; motions stay files until the study
makes them poses."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.body.bodies import body_path, load_body
from workbench.files.catalogue import find, is_file
from workbench.files.crash.crash_restraints import Restraints, restraints_of
from workbench.files.crash.restraints import contact_faults
from workbench.files.crash.schema import CrashCriterionFile, CrashFile, MotionSource, RulesFile
from workbench.files.environments import environment_files, load_environment
from workbench.files.schema import fail, validate
from workbench.files.yaml_text import Document, read_yaml
from workbench.model.body import Body
from workbench.model.crash import CrashCriterion, Limit, SignalPoint
from workbench.model.environment import Environment

__all__ = ["CrashPlan", "load_crash"]


@dataclass(frozen=True, eq=False)
class CrashPlan:
    """A crash study as its file has it: what is loaded, and the motion files with how they are to
    be read. restraints: what holds the occupant of the motion, and of the one it is compared
    with."""

    file: CrashFile
    environment: Environment
    body: Body
    motion: tuple[Path, MotionSource]
    against: tuple[Path, MotionSource] | None
    points: tuple[SignalPoint, ...]
    limits: tuple[Limit, ...]
    criteria: tuple[CrashCriterion, ...]
    inputs: dict[str, Path]
    restraints: Restraints
    other_restraints: Restraints


def load_crash(source: str | Path) -> CrashPlan:
    """Load a crash study by catalogue name or path. InputError lists every fault with its line."""
    path = find("studies", str(source))
    document = read_yaml(path)
    file = validate(document, CrashFile)
    faults: list[str] = []
    inputs = {"study": path}
    environment, body = _loaded(document, file, (path, inputs, faults))
    motion = _motion(document, file.motion, ("motion", path, faults))
    against = _motion(document, file.against, ("against", path, faults)) if file.against else None
    limits = _limits(document, file, (path, inputs, faults))
    if environment is None or body is None:
        raise InputError(faults)
    work = (environment, body, inputs)
    held, more = restraints_of(document, file, "motion", work)
    other, also = restraints_of(document, file, "against", work)
    parts = tuple(dict.fromkeys((*environment.parts, *held.names, *other.names)))
    faults += more + [line for line in also if line not in more]
    faults += _name_faults(document, file, (parts, body, limits))
    if faults:
        raise InputError(faults)
    inputs |= {"motion": motion} | ({"motion to compare with": against} if against else {})
    points = tuple(SignalPoint(p.name, body.segment(p.segment), p.at) for p in file.points)
    known = {body.segments[p.segment] for p in points}
    points += tuple(
        SignalPoint(body.segment_names[body.segment(s)], body.segment(s), (0.0, 0.0, 0.0))
        for s in dict.fromkeys(limit.segment for limit in limits)
        if s not in known
    )
    return CrashPlan(
        file,
        environment,
        body,
        (motion, file.motion),
        (against, file.against) if against is not None and file.against is not None else None,
        points,
        limits,
        tuple(_criterion(row, parts, body) for row in file.criteria),
        inputs,
        held,
        other,
    )


Work = tuple[Path, dict[str, Path], list[str]]


def _loaded(
    document: Document, file: CrashFile, work: Work
) -> tuple[Environment | None, Body | None]:
    path, inputs, faults = work
    environment = body = None
    try:
        source = find("environments", file.environment, "environment.yaml", near=path.parent)
        environment = load_environment(source)
        inputs |= {
            f"environment: {p.relative_to(source.parent)}": p for p in environment_files(source)
        }
    except InputError as error:
        faults += [fail(document, ("environment",), problem) for problem in error.problems]
    try:
        where = body_path(file.body, near=path.parent)
        body = load_body(where)
        inputs["body"] = where
    except InputError as error:
        faults += [fail(document, ("body",), problem) for problem in error.problems]
    return environment, body


def _motion(document: Document, source: MotionSource, work: tuple[str, Path, list[str]]) -> Path:
    key, path, faults = work
    found = path.parent / source.file
    if not is_file(found):
        faults.append(
            fail(document, (key, "file"), f"no such file {source.file!r} in {path.parent}")
        )
    if source.start is not None and source.end is not None and source.start >= source.end:
        faults.append(
            fail(
                document,
                (key, "end"),
                f"end {source.end:g} s must be after start {source.start:g} s",
            )
        )
    if key == "against" and source.scale != "body":
        faults.append(
            fail(
                document,
                (key, "scale"),
                "one body makes both motions: its scale belongs to 'motion'",
            )
        )
    return found


def _limits(document: Document, file: CrashFile, work: Work) -> tuple[Limit, ...]:
    path, inputs, faults = work
    if file.rules is None:
        return ()
    try:
        where = find("studies/rules", file.rules, near=path.parent)
        rules = validate(read_yaml(where), RulesFile)
    except InputError as error:
        faults += [fail(document, ("rules",), problem) for problem in error.problems]
        return ()
    inputs["rules"] = where
    spans = {"hic": np.inf, "held": 0.003}
    return tuple(
        Limit(
            row.figure,
            row.segment,
            (row.window if row.figure == "hic" else row.hold) or spans[row.figure],
            row.limit,
            row.source,
        )
        for row in rules.limits
    )


def _name_faults(
    document: Document, file: CrashFile, loaded: tuple[tuple[str, ...], Body, tuple[Limit, ...]]
) -> list[str]:
    parts, body, limits = loaded
    faults = contact_faults(document, file.forces, (body, parts), key="forces")
    for row, point in enumerate(file.points):
        if point.segment not in body.segments:
            what = f"body {body.name} has no segment {point.segment!r}; {one_of(point.segment, body.segments)}"
            faults.append(fail(document, ("points", row, "segment"), what))
    faults += [
        fail(
            document,
            ("rules",),
            f"limits segment {limit.segment!r}, which body {body.name} has not",
        )
        for limit in limits
        if limit.segment not in body.segments
    ]
    names: dict[str, Iterable[str]] = {"segments": body.segments, "parts": parts}
    seen: set[str] = set()
    for row, criterion in enumerate(file.criteria):
        if criterion.name in seen:
            faults.append(
                fail(
                    document,
                    ("criteria", row, "name"),
                    f"two criteria are named {criterion.name!r}",
                )
            )
        seen.add(criterion.name)
        if criterion.check == "rules" and file.rules is None:
            faults.append(
                fail(
                    document,
                    ("criteria", row, "check"),
                    "the study names no rule set (rules: fmvss_208)",
                )
            )
        for field, known in names.items():
            for place, name in enumerate(getattr(criterion, field) or ()):
                if not any(fnmatchcase(k, name) for k in known):
                    what = f"nothing is called {name!r}; {one_of(name, known)}"
                    faults.append(fail(document, ("criteria", row, field, place), what))
    return faults


def _criterion(row: CrashCriterionFile, parts: tuple[str, ...], body: Body) -> CrashCriterion:
    def matching(patterns: list[str] | None, known: Iterable[str]) -> tuple[str, ...]:
        return tuple(
            k for k in known if patterns is None or any(fnmatchcase(k, p) for p in patterns)
        )

    direction = np.array(row.direction or (1.0, 0.0, 0.0))
    x, y, z = direction / np.linalg.norm(direction)
    at_most = float(np.radians(row.degrees or 0.0)) if row.check == "stops" else row.at_most or 0.0
    return CrashCriterion(
        row.name,
        row.check,
        matching(row.segments, body.segments),
        matching(row.parts, parts),
        at_most,
        (float(x), float(y), float(z)),
        row.origin or (0.0, 0.0, 0.0),
    )
