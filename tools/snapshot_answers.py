"""What the workbench answers: the one place of the snapshot that knows the package.

Each function asks one question and yields answers under names that stay when the package changes.
When an interface or the study format changes, change the body of the function, not the names.
COLLECTORS lists the questions.

The names use these parts:

- a body, an environment, a seat, a posture, a study: its name in the catalogue
- a role: the name of a person in a study; of a study about many people `pilot` or `driver`
- a case: its name in a study; of a crash the name of its motion
- a segment, a joint: its mnemonic; a part, a control, a criterion, a requirement, a measure: its
  own name
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import io
import math
import re
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import workbench as wb
from workbench.body.people.growth_charts import growth_people
from workbench.body.people.percentile import percentile_people
from workbench.body.people.proportions import bootstrap_share, paired_share, proportion_interval
from workbench.body.wear import wear
from workbench.cli import main as command
from workbench.errors import InputError
from workbench.files.body.encumbrances import load_encumbrances
from workbench.files.catalogue import names
from workbench.files.motions.number_rows import FrameRange
from workbench.files.populations import load_growth
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.model.joint_angles import angles_of
from workbench.model.result import MotionFound, PosturesFound, Verdict
from workbench.model.study import PeopleDrawn
from workbench.motion.recorded.marker_names import marker_site
from workbench.motion.recorded.subject_scaling import marker_places
from workbench.motion.signals import cfc_filter, hic, sustained_level
from workbench.study.motions import MotionOptions, load_motion
from workbench.study.run import run

ROOT = Path(__file__).resolve().parents[1]
RECORDED = ROOT.parent / "shared" / "data" / "motion"
"""Recorded motions, which are no part of the repository; without them the answers about them are
missing."""
PEOPLE = 40
"""People of each study about a population."""
GREY = (32, 24)
"""Columns and rows of the small grey picture that is kept of each picture."""

Answers = dict[str, Any]
Named = Iterator[tuple[str, Any]]
Floats = NDArray[np.float64]


def collected(
    wanted: Sequence[str], *, say: Callable[[str], None] = lambda text: None
) -> dict[str, Answers]:
    """The answers to some of the COLLECTORS' questions by name, a section for each question."""
    sections: dict[str, Answers] = {}
    names_so_far: set[str] = set()
    for section in wanted:
        begun = time.perf_counter()
        answers = sections[section] = {}
        for name, value in COLLECTORS[section]():
            if name in names_so_far:
                raise ValueError(f"two answers are named {name!r}")
            names_so_far.add(name)
            answers[name] = value
        say(f"{section}: {len(answers)} entries in {time.perf_counter() - begun:.1f} s")
    return sections


_body = functools.cache(wb.load_body)
_environment = functools.cache(wb.load_environment)


# ---- bodies
# --------------------------------------------------------------------------------------------------------


def bodies() -> Named:
    """What each body of the catalogue is, what it measures, and how it stands in its postures."""
    for name in names("bodies"):
        yield from body_alone(name)


def body_alone(name: str) -> Named:
    """What one body is, what it measures, and how it stands in its postures, without an
    environment."""
    body = _body(name)
    yield f"body/{name}", _summary(body)
    with contextlib.suppress(InputError):  # a dog has no sitting height
        yield f"measure/{name}", _measures(body)
    postures = _postures(name)
    placed = wb.place(body, wb.join_poses(list(postures.values())))
    own = wb.self_contacts(placed)
    for row, (posture, poses) in enumerate(postures.items()):
        here = f"{name}/{posture}"
        yield f"placed/{here}", _spheres(placed, row)
        margins = wb.stops(body, poses)
        free = np.isinf(margins.margin[0])
        for j, joint in enumerate(body.joints):
            if not free[j]:
                yield (
                    f"stop/{here}/{joint}",
                    {
                        "margin_deg": math.degrees(margins.margin[0, j]),
                        "nearest": margins.motion(0, j),
                    },
                )
        yield from _contacts(f"self_contact/{here}", own.rows(own.pose == row))


def in_seats() -> Named:
    """How each human body sits in each seat in each of its postures, what it is near to and what it
    touches."""
    for name in names("bodies"):
        for environment in names("environments", "environment.yaml"):
            for seat in _environment(environment).seats:
                if "driving" in _postures(name):
                    yield from body_in_seat(name, environment, seat.name)


def body_in_seat(name: str, environment: str, seat: str, *, wanted: Sequence[str] = ()) -> Named:
    """How one body sits in one seat: spheres, clearances and contacts, in each of its postures or
    in those wanted."""
    body = _body(name)
    around = _environment(environment)
    postures = {
        posture: poses
        for posture, poses in _postures(name).items()
        if not wanted or posture in wanted
    }
    placed = _seated(body, postures, around, seat)
    distance = wb.clearance(placed, around)
    touching = wb.contacts(placed, around)
    for row, posture in enumerate(postures):
        here = f"{name}/{environment}/{seat}/{posture}"
        yield f"seated/{here}", _spheres(placed, row)
        yield from _clearances(f"clearance/{here}", body, around, distance[row])
        yield from _contacts(f"contact/{here}", touching.rows(touching.pose == row))


def _seated(
    body: wb.Body, postures: Mapping[str, wb.Poses], around: wb.Environment, seat: str
) -> wb.Placed:
    """A body in a seat that stands in its reference position, a row for each posture."""
    poses = wb.join_poses(list(postures.values()))
    held = around.seat(seat).held(0.0, 0.0)
    return wb.place(body, wb.seat(body, poses, held).poses)


def controls() -> Named:
    """How near each limb of two bodies gets to each control from each seat, obstacles aside, in the
    control's zone."""
    for name in ("adult_female", "adult_male"):
        body = _body(name)
        posture = {"driving": _postures(name)["driving"]}
        for environment in names("environments", "environment.yaml"):
            around = _environment(environment)
            for seat in around.seats:
                placed = _seated(body, posture, around, seat.name)
                yield from _reaches(f"reach/{name}/{environment}/{seat.name}", placed, around)


def _reaches(name: str, placed: wb.Placed, around: wb.Environment) -> Named:
    """Reaches from the one posture of a placed body, by control and limb."""
    body = placed.body
    start = _postures(placed.body.name)["driving"]
    poses = wb.Poses(
        start.rotations, start.reference, placed.world_from_segment[:, start.reference]
    )
    for grip, zone in sorted({(control.grip, control.zone) for control in around.controls}):
        some = [
            control for control in around.controls if (control.grip, control.zone) == (grip, zone)
        ]
        foot = grip == "foot"
        for limb in ("left foot", "right foot") if foot else ("left hand", "right hand"):
            chain = wb.limb(body, limb, grip="ball" if foot else grip, zone=zone)
            found = wb.reach(body, poses, np.array([control.at for control in some]), limb=chain)
            for row, control in enumerate(some):
                yield (
                    f"{name}/{control.name}/{limb}",
                    {
                        "reached": bool(found.reached[0, row]),
                        "miss_mm": 1000 * float(found.miss[0, row]),
                        "limit": found.limit(0, row),
                        "discomfort": float(found.discomfort[0, row]),
                    },
                )


@functools.cache
def _postures(name: str) -> dict[str, wb.Poses]:
    """The postures that a body's file names, one pose each."""
    body = _body(name)
    path = posture_path(name)
    if path is None:
        return {}
    file, _ = load_postures(path, body)
    return {posture: posture_pose(body, file, posture) for posture in file.postures}


def _summary(body: wb.Body) -> Answers:
    return {
        "segments": len(body.segments),
        "joints": len(body.joints),
        "spheres": len(body.sphere_names),
        "mass_kg": float(body.mass[0].sum()),
        "radii_mm": 1000 * float(body.radius[0].sum()),
    }


def _measures(body: wb.Body) -> Answers:
    return {measure: 1000 * value for measure, value in wb.measure(body).items()}


def _spheres(placed: wb.Placed, row: int) -> Answers:
    """A hash of all sphere centres to a nanometre; by segment their mean and their spread about it
    [mm]."""
    body = placed.body
    centres = placed.centres[row]
    found: Answers = {"sha256": _sha(np.rint(1e9 * centres).astype(np.int64).tobytes())}
    for n, segment in enumerate(body.segments):
        own = 1000 * centres[body.spheres(n)]
        if len(own):
            middle = own.mean(axis=0)
            found[segment] = [
                *middle.tolist(),
                float(np.sqrt(np.mean(np.sum((own - middle) ** 2, axis=1)))),
            ]
    return found


def _clearances(name: str, body: wb.Body, environment: wb.Environment, distance: Floats) -> Named:
    """Distances (N, K) [m] by segment and part; what is infinite has no answer."""
    for n, segment in enumerate(body.segments):
        row = {
            part: 1000 * float(distance[n, k])
            for k, part in enumerate(environment.parts)
            if not np.isinf(distance[n, k])
        }
        if row:
            yield f"{name}/{segment}", row


def _contacts(name: str, found: wb.Contacts) -> Named:
    """By segment and part (or other segment): the pairs that touch, the deepest, and how far beyond
    what is allowed.

    A pair is the number of the sphere in its segment and that of the polygon in its part (or of the
    other sphere in its segment).
    """
    body = found.body
    other = found.other
    sphere = found.sphere - body.start[found.segment]
    if isinstance(other, wb.Environment):
        labels = other.parts
        against = found.part
        target = found.polygon - other.part_start[found.part]
    else:
        labels = other.segments
        against = found.other_segment
        target = found.other_sphere - other.start[found.other_segment]
    for n, k in sorted(set(zip(found.segment.tolist(), against.tolist(), strict=True))):
        rows = np.flatnonzero((found.segment == n) & (against == k))
        yield (
            f"{name}/{body.segments[n]}/{labels[k]}",
            {
                "pairs": [f"{sphere[row]}:{target[row]}" for row in rows],
                "deepest_mm": -1000 * float(found.distance[rows].min()),
                "beyond_mm": 1000 * float(found.excess[rows].max()),
            },
        )


# ---- sizes and people
# ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Size:
    """A person to be made: from which body, of what sex, with which measures [m] and clothes; of a
    child its age."""

    body: str
    sex: str
    measures: Mapping[str, float]
    age: float | None = None
    detail: str | None = None
    clothes: tuple[str, ...] = ()


SIZES = {
    "small woman": Size(
        "bubbleman",
        "female",
        {
            "stature": 1.525,
            "sitting_height": 0.803,
            "buttock_knee_length": 0.541,
            "thumb_tip_reach": 0.674,
        },
    ),
    "large man": Size(
        "bubbleman",
        "male",
        {
            "stature": 1.870,
            "sitting_height": 0.977,
            "buttock_knee_length": 0.669,
            "thumb_tip_reach": 0.886,
        },
    ),
    "heavy man": Size("adult_male", "male", {"stature": 1.75, "mass": 120.0}, detail="coarse"),
    "slight woman": Size(
        "adult_female", "female", {"stature": 1.55, "mass": 48.0}, detail="medium"
    ),
    "boy of five": Size("child_6", "male", {}, age=5.0),
    "pilot with helmet, vest and boots": Size(
        "adult_male", "male", {"stature": 1.80}, clothes=("helmet", "vest", "boots")
    ),
}


def sizes() -> Named:
    """What some bodies made to measure are, and what they then measure."""
    for name, size in SIZES.items():
        people = wb.load_population_model("ansur2") if size.age is None else load_growth()
        made = wb.person_body(
            _body(size.body),
            people,
            sex=size.sex,
            measures=size.measures,
            age=size.age,
            detail=size.detail,
        )
        dressed = wear(made.body, load_encumbrances(list(size.clothes), made.body))
        yield f"size/{name}", _summary(dressed)
        yield f"size/{name}/measure", _measures(made.body)
        posture, poses = next(iter(_postures(size.body).items()))
        poses = wb.Poses(poses.rotations, poses.reference, poses.world_from_reference)
        yield f"size/{name}/{posture}", _spheres(wb.place(dressed, poses), 0)


def people() -> Named:
    """Percentiles, boundary cases, drawn people, growing children, shares and their intervals."""
    model = wb.load_population_model("ansur2")
    for sex in ("male", "female"):
        yield from _persons(f"percentile/{sex}", percentile_people(model, sex, [1, 5, 50, 95, 99]))
        boundary = wb.boundary_cases(model, sex, share=0.95)
        yield from _persons(f"boundary/{sex}", boundary.people)
        yield (
            f"boundary/{sex}",
            {"radius": boundary.radius, "explained": boundary.explained.tolist()},
        )
        for age in (3, 9.5, 17):
            yield from _persons(
                f"growth/{sex}/{age:g} years",
                growth_people(load_growth(), sex, [3, 50, 97], age=age),
            )
    yield from _persons("drawn", wb.draw_people(model, 12, seed=1))
    yield from _persons("synthetic", wb.draw_people(model, 12, seed=1, synthetic=True))
    served = np.arange(60) % 7 != 3
    later = np.arange(60) % 5 != 1
    weight = 1.0 + np.arange(60) % 3
    found = proportion_interval(served, weight=weight)
    yield "interval/wilson", [found.share, found.low, found.high]
    found = bootstrap_share(served, weight=weight, seed=5, draws=2000)
    yield "interval/bootstrap", [found.share, found.low, found.high]
    pair = paired_share(served, later, weight=weight)
    yield "interval/paired", [pair.difference, pair.low, pair.high, pair.chance]


def _persons(name: str, found: Any) -> Named:
    """Measures of people by label, or by their number where nobody has one; lengths in mm, mass in
    kg."""
    for row in range(len(found)):
        label = found.labels[row] if found.labels else str(row + 1)
        yield (
            f"{name}/{label}",
            {
                measure: float(value) * (1.0 if measure == "mass" else 1000.0)
                for measure, value in zip(found.names, found.measures[row], strict=True)
            },
        )


# ---- signals and motions
# -------------------------------------------------------------------------------------------


def signals() -> Named:
    """Injury figures and filters of signals that formulas give."""
    clock = np.arange(2001) / 10_000
    pulse = 60 * 9.80665 * np.sin(np.pi * np.clip((clock - 0.02) / 0.09, 0, 1)) ** 2
    rough = pulse + 120 * np.sin(2 * np.pi * 310 * clock) + 45 * np.cos(2 * np.pi * 1170 * clock)
    for label, level in (("smooth", pulse), ("rough", rough)):
        for window in (0.015, 0.036):
            worst = hic(clock, level, window=window)
            yield f"signal/{label}/hic {1000 * window:g} ms", [worst.value, worst.start, worst.end]
        yield f"signal/{label}/held 3 ms", sustained_level(clock, level)
        for cfc in (60, 180, 600):
            yield f"signal/{label}/cfc {cfc}", cfc_filter(clock, level, cfc=cfc)[::100].tolist()


def motions() -> Named:
    """Motions that come along, written in each form and read again; and recorded motions where they
    are at hand."""
    body = _body("bubbleman")
    lap = ROOT / "studies" / "motions" / "trainer_lap.csv"
    greeting = ROOT / "docs" / "examples" / "greeting.laban"
    with tempfile.TemporaryDirectory() as folder:
        short = Path(folder) / "short.csv"
        made = Path(folder)
        _asked("motion", "convert", str(lap), "--out", str(short), "--every", "8")
        yield from _motion("trainer_lap", body, lap)
        yield from _motion("greeting", body, greeting)
        _asked("motion", "convert", str(short), "--out", str(made / "a.bvh"))
        own = {segment: segment for segment in body.segments[1:]}
        yield from _motion(
            "trainer_lap as bvh",
            body,
            made / "a.bvh",
            MotionOptions(names=own, metres=0.01, up="y"),
        )
        _asked("motion", "convert", str(greeting), "--out", str(made / "b.csv"))
        yield from _motion("greeting as csv", body, made / "b.csv")
        _asked(
            "motion",
            "convert",
            str(made / "b.csv"),
            "--out",
            str(made / "c.laban"),
            "--tempo",
            "60",
        )
        score = (made / "c.laban").read_text().splitlines()
        yield "motion/greeting as laban", {"score": [re.sub(r"\s+", " ", line) for line in score]}
        (made / "d.trc").write_text(_trc(body, short))
        yield from _motion("trainer_lap as trc", body, made / "d.trc")
    recorded = {
        "jump as bvh": ("bvh/01_01.bvh", MotionOptions(keep=FrameRange(every=100))),
        "walk as trc": ("trc/bmc_walk1.trc", MotionOptions(keep=FrameRange(every=10), gaps=0.2)),
        "walk as c3d": (
            "c3d/bmc_Gait.c3d",
            MotionOptions(keep=FrameRange(1.33, 4.2, 20), gaps=0.2),
        ),
    }
    for name, (file, options) in recorded.items():
        if (RECORDED / file).is_file():
            yield from _motion(name, body, RECORDED / file, options)


def _motion(name: str, body: wb.Body, path: Path, options: MotionOptions | None = None) -> Named:
    """Length of a motion, and the angles of each joint and the place of the body at five of its
    frames."""
    poses, notes = load_motion(body, path, options=options)
    rows = np.linspace(0, len(poses) - 1, 5).round().astype(int)
    angles = np.degrees(angles_of(body, poses))[rows]
    yield (
        f"motion/{name}",
        {
            "frames": len(poses),
            "notes": len(notes),
            "span_s": [float(poses.clock[0]), float(poses.clock[-1])],
            "place_mm": (1000 * poses.world_from_reference[rows, :, 3]).tolist(),
        },
    )
    yield (
        f"motion/{name}/angles_deg",
        {joint: angles[:, j].tolist() for j, joint in enumerate(body.joints)},
    )


def _trc(body: wb.Body, motion: Path) -> str:
    """A marker file of a motion: where markers on the skin of the body go."""
    sided = [
        "FHD",
        "BHD",
        "SHO",
        "ELB",
        "WRA",
        "WRB",
        "FIN",
        "ASI",
        "PSI",
        "THI",
        "KNE",
        "TIB",
        "ANK",
        "HEE",
        "TOE",
    ]
    labels = [side + name for side in "LR" for name in sided] + ["C7", "T10", "CLAV", "STRN"]
    poses, _ = load_motion(body, motion)
    sites = {label: site for label in labels if (site := marker_site(label)) is not None}
    local, _ = marker_places(body, sites)
    carrier = np.array([body.segment(site.segment) for site in sites.values()])
    world = wb.place(body, poses).world_from_segment[:, carrier]
    at = 1000 * (np.einsum("pmij,mj->pmi", world[..., :3], local) + world[..., 3])
    frames = len(poses)
    rate = round((len(poses) - 1) / float(poses.clock[-1] - poses.clock[0]))
    head = [
        "PathFileType\t4\t(X/Y/Z)\tmade.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits",
        f"{rate}\t{rate}\t{frames}\t{len(labels)}\tmm",
        "Frame#\tTime\t" + "\t\t\t".join(labels) + "\t\t",
        "\t\t" + "\t".join(f"{axis}{m}" for m in range(1, len(labels) + 1) for axis in "XYZ"),
        "",
    ]
    lines = [
        f"{p + 1}\t{poses.clock[p]:.5f}\t" + "\t".join(f"{value:.5f}" for value in at[p].ravel())
        for p in range(frames)
    ]
    return "\n".join(head + lines) + "\n"


def _asked(*words: str) -> None:
    """Run a command of the workbench, quietly; RuntimeError where it fails."""
    told = io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
        code = command(words)
    if code:
        raise RuntimeError(f"workbench {' '.join(words)}: exit code {code}: {told.getvalue()}")


# ---- studies
# -------------------------------------------------------------------------------------------------------


def clearance_study() -> Named:
    """What the study of two men in the trainer finds."""
    result = _ran("trainer_clearance")
    yield from _present(result)
    for person in result.people:
        for case, name in enumerate(result.cases):
            here = f"trainer_clearance/{person.name}/{name}"
            body = person.placed.body
            environment = result.environment
            yield f"seated/{here}", _spheres(person.placed, case)
            yield from _clearances(
                f"clearance/{here}", body, environment, person.clearance.distance[case]
            )
            yield from _contacts(
                f"contact/{here}", person.contacts.rows(person.contacts.pose == case)
            )
    for (one, other), found in result.between.items():
        near = wb.body_clearance(*(person.placed for person in result.people)).distance
        for case, name in enumerate(result.cases):
            yield (
                f"between/trainer_clearance/{one} and {other}/{name}",
                {"nearest_mm": 1000 * float(near[case].min())},
            )
            yield from _contacts(
                f"between/trainer_clearance/{one} and {other}/{name}",
                found.rows(found.pose == case),
            )


def reach_study() -> Named:
    """What the study of a small woman and a large man finds: seats, postures, controls,
    envelopes."""
    result = _ran("trainer_reach")
    yield from _present(result)
    for person in result.people:
        seat = next(one for one in result.environment.seats if one.name == person.role.seat)
        yield f"seat/trainer_reach/{person.name}", {"srp_mm": [1000 * value for value in seat.srp]}
        for case, name in enumerate(result.cases):
            yield f"seated/trainer_reach/{person.name}/{name}", _spheres(person.placed, case)
    for row in result.reaches:
        yield (
            f"reach/trainer_reach/{row.person}/{row.control}/zone {row.zone}",
            {
                "reached": row.reached,
                "limb": row.limb,
                "miss_mm": 1000 * row.miss,
                "overlap_mm": 1000 * row.overlap,
                "limit": row.limit.text,
                "discomfort": row.discomfort,
            },
        )
    for found in result.envelopes:
        about = found.about
        yield (
            f"envelope/trainer_reach/{found.person}/{found.limb.split(',')[0]}",
            {
                "volume_litres": 1000 * found.volume,
                "lost_litres": 1000 * found.lost,
                "rays": len(about),
                "reached": about.reached.tolist(),
                "outer_mm": (1000 * about.outer).tolist(),
                "inner_mm": (1000 * about.inner).tolist(),
                "clear_outer_mm": (1000 * about.clear_outer).tolist(),
            },
        )


def _ran(name: str) -> PosturesFound:
    (found,) = run(wb.load_study(name)).postures
    return found


def _present(result: PosturesFound) -> Named:
    """Verdicts, and by criterion, role and case the margin, of a study about people who are present
    at once."""
    study = result.study
    yield f"study/{study.name}", {"passed": result.passed, "warnings": len(result.warnings)}
    for verdict in result.verdicts:
        criterion = verdict.criterion
        degrees = criterion.check == "stops"
        unit, factor = ("deg", 180 / math.pi) if degrees else ("mm", 1000.0)
        answer: Answers = {"passed": verdict.passed, "breaches": len(verdict.breaches)}
        if verdict.worst is not None:
            worst = verdict.worst
            answer[f"value_{unit}"] = factor * worst.value
            answer[f"margin_{unit}"] = factor * (worst.value - worst.limit)
            answer["where"] = f"{worst.case}, {worst.person}: {worst.subject}, {worst.target}"
        yield f"verdict/{study.name}/{criterion.name}", answer


def trainer_people() -> Named:
    """Who fits the trainer's left seat."""
    yield from _population("trainer_accommodation", "pilot")


def car_people() -> Named:
    """Who can drive the compact car."""
    yield from _population("car_driver", "driver")


def _population(name: str, role: str) -> Named:
    """Margins of PEOPLE people by requirement, in their order; their seats; shares, reach maps and
    design changes."""
    study = wb.load_study(name)
    (who,) = study.roles
    assert isinstance(who.population, PeopleDrawn)
    result = run(study.with_(people={who.name: {"population": {"people": PEOPLE}}})).population
    assert result is not None
    here = f"{name}/{role}"
    for r, one in enumerate(result.requirements):
        name = f"{one.criterion}/{one.target}" if one.check == "reach" else one.criterion
        yield (
            f"fit/{here}/{name}",
            {
                "met": result.met[:, r].tolist(),
                "margin_mm": (1000 * result.margin[:, r]).tolist(),
                "limit": [result.reasons[k].text if k >= 0 else "" for k in result.reason[:, r]],
                "share": float(result.single[r]),
                "share_without": float(result.without[r]),
                "only": float(result.only[r]),
                "spread_mm": (1000 * result.spread[r]).tolist(),
            },
        )
    yield (
        f"fit/{here}",
        {
            "served": result.served.tolist(),
            "seat_mm": (1000 * result.seat).tolist(),
            "limiting": list(result.limiting),
            "hardest": list(result.hardest),
            "warnings": len(result.warnings),
        },
    )
    for share in result.shares:
        yield (
            f"share/{here}/{share.group}",
            {
                "share": share.share,
                "low": share.low,
                "high": share.high,
                "people": share.count,
            },
        )
    for gain in result.gains:
        yield (
            f"change/{here}/{gain.words}",
            {
                "before": gain.before,
                "after": gain.after,
                "all_before": gain.joint_before,
                "all_after": gain.joint_after,
            },
        )
    for found in result.maps:
        task = found.task
        yield (
            f"reach_map/{here}/{task.part}/{task.grip}/zone {task.zone}",
            {
                "points_mm": (1000 * found.points).tolist(),
                "share": found.share.tolist(),
            },
        )


def crash_study() -> Named:
    """What the crash in the trainer does, with each set of belts: contacts, injury figures,
    excursions, forces."""
    result = run(wb.load_study("trainer_crash"))
    for one in result.motions:
        case = one.study.name
        yield f"study/trainer_crash/{case}", {"passed": one.passed, "warnings": len(one.warnings)}
        for verdict in one.verdicts:
            yield f"verdict/trainer_crash/{verdict.criterion.name}/{case}", _crash_verdict(verdict)
        yield from _crash(case, one)
    for row in result.agreements:
        yield (
            f"crash/difference/{row.name}",
            {"rms_mm": 1000 * row.rms, "peak_mm": 1000 * row.peak, "peak_s": row.at},
        )


def _crash_verdict(verdict: Verdict) -> Answers:
    """How a criterion of a motion came out: how much of what it limits there is, positive, and when,
    in mm, degrees, g or a number."""
    worst = verdict.worst
    if worst is None:
        return {"passed": verdict.passed, "value": 0.0, "margin": 0.0, "at_s": math.nan}
    factor = {"m": 1000.0, "rad": math.degrees(1.0)}.get(worst.unit, 1.0)
    value = -factor * worst.value
    limit = -factor * worst.limit
    if verdict.criterion.check == "contact":  # beyond what the part allows
        value -= limit - 1000 * verdict.criterion.at_most
        limit = 1000 * verdict.criterion.at_most
    return {
        "passed": verdict.passed,
        "value": value,
        "margin": limit - value,
        "at_s": worst.time,
    }


def _crash(case: str, result: MotionFound) -> Named:
    """What one motion of a crash does."""
    study = result.study
    met: dict[str, int] = {}
    for row in result.meetings:
        pair = f"{row.segment}/{row.other}"
        met[pair] = met.get(pair, 0) + 1
        yield (
            f"crash/{case}/contact/{pair}/{met[pair]}",
            {
                "enter_s": row.enter,
                "deepest_s": row.deepest,
                "leave_s": row.leave,
                "began": row.began,
                "lasts": row.lasts,
                "depth_mm": 1000 * row.depth,
                "allowed_mm": 1000 * row.allowed,
                "speed_m_s": row.speed,
                "normal_m_s": row.normal,
                "tangential_m_s": row.tangential,
                "point_mm": [1000 * value for value in row.point],
                "force_n": row.force,
            },
        )
    past: dict[str, int] = {}
    for row in result.breaches:
        motion = f"{row.joint}/{row.motion}"
        past[motion] = past.get(motion, 0) + 1
        yield (
            f"crash/{case}/past stop/{motion}/{past[motion]}",
            {
                "begin_s": row.begin,
                "end_s": row.end,
                "worst_deg": math.degrees(row.worst),
                "at_s": row.at,
            },
        )
    for signal in result.signals:
        yield (
            f"crash/{case}/signal/{signal.point.name}",
            {
                **{figure: list(values) for figure, values in signal.figures.items()},
                "acceleration_m_s2": signal.acceleration[::20].tolist(),
            },
        )
    for n, segment in enumerate(study.body.segments):
        near = result.clearance[:, n]
        if np.isfinite(near).any():
            worst = int(np.argmin(near))
            yield (
                f"crash/{case}/clearance/{segment}",
                {
                    "least_mm": 1000 * float(near[worst]),
                    "at_s": float(study.motion.clock[worst]),
                    "over_time_mm": (1000 * near[::10]).tolist(),
                },
            )
    for curve in result.forces:
        yield (
            f"crash/{case}/force/{curve.segment or 'belt'}/{curve.part}",
            {
                "peak_n": float(curve.force.max()),
                "over_time_n": curve.force[::10].tolist(),
            },
        )
    placed = wb.place(study.body, study.motion)
    distance = wb.clearance(placed, study.cabin)
    yield (
        f"crash/{case}",
        {"deeper_than_30_mm": wb.collides(placed, study.cabin, tolerance=0.03).tolist()},
    )
    yield from _clearances(f"crash/{case}/least", study.body, study.cabin, distance.min(axis=0))


# ---- pictures
# ------------------------------------------------------------------------------------------------------

PICTURES: dict[str, str] = {
    **{
        f"{body} standing.png": f"{body} --view front"
        for body in ("adult_female", "adult_male", "child_3", "child_6")
    },
    "dog.png": "dog --view left",
    **{
        f"bubbleman {posture}.png": f"bubbleman --pose {posture} --view corner"
        for posture in (
            "standing",
            "t_pose",
            "seated",
            "hands_in_lap",
            "driving",
            "reaching",
            "crouched",
        )
    },
    **{
        f"bubbleman {style}.png": f"bubbleman --style {style} --view left"
        for style in ("flat", "hidden_line", "depth", "id")
    },
    **{
        f"bubbleman scanline {style}.png": f"bubbleman --display scanline --style {style}"
        for style in ("surface", "front")
    },
    "bubbleman outline.svg": "bubbleman --display outline --view front",
    "bubbleman circles.svg": "bubbleman --display circles --view front",
    "trainer.png": "trainer --view corner",
    "compact_car.png": "compact_car --view corner",
    "two men.png": "trainer_clearance --view front --marks contacts,clearances",
    "two men cut.png": "trainer_clearance --view left --cut left --marks controls,axes",
    "two men outline.svg": "trainer_clearance --display outline --style hidden_line --view left",
    "what the pilot sees.png": "trainer_clearance --view eye",
    "crash.png": "trainer_crash --view left --at 0,50ms,100ms",
    "crash with ghosts.png": "trainer_crash --view left --at 100ms --trail 3",
}
"""A picture's name, and how `workbench render` is asked for it."""


def pictures() -> Named:
    """How the catalogue and the studies are drawn."""
    with tempfile.TemporaryDirectory() as folder:
        for name, words in PICTURES.items():
            yield f"picture/{name}", picture(Path(folder) / name, words)


def picture(path: Path, words: str) -> Answers:
    """How one picture is drawn: a hash of the file, and numbers that say how much another one
    differs."""
    _asked("render", *words.split(), "--size", "320x240", "--out", str(path))
    data = path.read_bytes()
    if path.suffix == ".svg":
        text = data.decode()
        numbers = [float(word) for word in re.findall(r"-?\d+(?:\.\d+)?", text)]
        tags = re.findall(r"<(\w+)", text)
        return {
            "sha256": _sha(data),
            "elements": {tag: tags.count(tag) for tag in sorted(set(tags))},
            "numbers": len(numbers),
            "sum": math.fsum(numbers),
        }
    with Image.open(path) as image:
        grey = image.convert("L").resize(GREY, Image.Resampling.BOX)
        return {
            "sha256": _sha(data),
            "pixels": list(image.size),
            "grey": np.asarray(grey).ravel().tolist(),
        }


def _sha(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]


COLLECTORS: dict[str, Callable[[], Named]] = {
    "bodies": bodies,
    "seats": in_seats,
    "sizes": sizes,
    "people": people,
    "signals": signals,
    "motions": motions,
    "clearance": clearance_study,
    "controls": controls,
    "reach": reach_study,
    "crash": crash_study,
    "trainer_people": trainer_people,
    "car_people": car_people,
    "pictures": pictures,
}
"""The questions by their sections, which `make --only` takes."""
