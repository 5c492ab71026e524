"""What a study says about reaching: the aims of predicted postures, and the envelopes it asks
for."""

from __future__ import annotations

from collections.abc import Iterator

from workbench.errors import one_of
from workbench.files.schema import fail
from workbench.files.study_schema import DRIVING, PREDICTED, CasePersonFile, DriverFile, StudyFile
from workbench.files.yaml_text import Document
from workbench.model.driving import DrivingAims
from workbench.model.environment import Environment
from workbench.model.study import Aims, ReachTask

__all__ = ["aim_faults", "aims_of", "driving_aims", "envelopes_of"]


def aims_of(case: CasePersonFile) -> Aims | None:
    """What the posture of a person in a case is predicted from; None where it is given."""
    if case.posture not in (PREDICTED, DRIVING):
        return None
    return Aims(
        {limb: control for limb, control, _ in _held(case)},
        case.eyes,
        case.heels,
        driving_aims(case.driver),
    )


def driving_aims(driver: DriverFile | None) -> DrivingAims | None:
    """What is said of a driver; None where nothing is."""
    if driver is None:
        return None
    return DrivingAims(driver.sex or "", driver.age, driver.seed, driver.wheel, driver.h_point)


def envelopes_of(file: StudyFile) -> tuple[ReachTask, ...]:
    """The reach envelopes a study asks for."""
    return tuple(
        ReachTask(e.person, f"{e.hand} hand", e.grip, e.zone, e.obstacles) for e in file.envelopes
    )


def aim_faults(document: Document, file: StudyFile, environment: Environment | None) -> list[str]:
    """Controls, points and people that are not there, hands on pedals and feet on knobs."""
    faults = []
    for row, envelope in enumerate(file.envelopes):
        if envelope.person not in file.people or file.people[envelope.person].seat is None:
            seated = [name for name, person in file.people.items() if person.seat is not None]
            what = (
                f"nobody called {envelope.person!r} is in a seat; {one_of(envelope.person, seated)}"
            )
            faults.append(fail(document, ("envelopes", row, "person"), what))
    if environment is None:
        return faults
    for row, case in enumerate(file.cases):
        for name, entry in case.people.items():
            key = ("cases", row, "people", name)
            person = file.people.get(name)
            if entry.posture in (PREDICTED, DRIVING) and person is not None and person.seat is None:
                faults.append(
                    fail(
                        document,
                        (*key, "posture"),
                        "only the posture of somebody in a seat is predicted",
                    )
                )
            if (
                entry.driver is not None
                and entry.driver.sex is None
                and person is not None
                and person.size is None
            ):
                what = "whether a man or a woman drives is not told: give 'sex', or the person a 'size'"
                faults.append(fail(document, (*key, "driver"), what))
            faults += _aim_faults(document, (entry, environment), key)
    return faults


def _aim_faults(
    document: Document, aims: tuple[CasePersonFile, Environment], key: tuple[str | int, ...]
) -> list[str]:
    case, environment = aims
    controls = {control.name: control for control in environment.controls}
    faults = []
    for limb, control, place in _held(case):
        if control not in controls:
            what = f"environment {environment.name} has no control {control!r}; {one_of(control, controls)}"
            faults.append(fail(document, (*key, *place), what))
        elif (controls[control].grip == "foot") != limb.endswith("foot"):
            what = f"{control} is for {'feet' if controls[control].grip == 'foot' else 'hands'}"
            faults.append(fail(document, (*key, *place), what))
    for field in ("eyes", "heels"):
        point = getattr(case, field)
        if point is not None and point not in environment.points:
            what = f"environment {environment.name} has no point {point!r}; {one_of(point, environment.points)}"
            faults.append(fail(document, (*key, field), what))
    for field in ("wheel", "h_point") if case.driver is not None else ():
        point = getattr(case.driver, field)
        if point not in environment.points:
            what = f"environment {environment.name} has no point {point!r}; {one_of(point, environment.points)}"
            faults.append(fail(document, (*key, "driver", field), what))
    return faults


def _held(case: CasePersonFile) -> Iterator[tuple[str, str, tuple[str, str]]]:
    """Limb, control and where in the case it stands, feet first."""
    for field, kind in (("feet", "foot"), ("hands", "hand")):
        for side in ("left", "right"):
            control = getattr(getattr(case, field), side)
            if control is not None:
                yield f"{side} {kind}", control, (field, side)
