"""Accommodations made up for the tests of their page: real names and people, invented margins."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import numpy as np

import workbench as wb
from tests.conftest import ROOT, tracked
from workbench import Result, draw_people
from workbench.body.people.proportions import proportion_interval
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.model.accommodation import (
    DesignChange,
    GroupShare,
    MapTask,
    ReachMap,
    Requirement,
)
from workbench.model.criterion import TOO_SHORT, Criterion, Reason
from workbench.model.result import Illustration, PopulationFound, TriedChange
from workbench.study.run import people_hash
from workbench.study.workplaces import workplace_of

__all__ = [
    "ACCOMMODATIONS",
    "made",
    "panel_map",
    "result_of",
    "smaller_study",
    "trainer_accommodation",
    "trainer_people",
]

ACCOMMODATIONS = [
    path.stem
    for path in tracked("studies/*.yaml")
    if "population: {" in path.read_text(encoding="utf-8")
]
"""Names of the shipped accommodation studies."""

REASONS = (
    TOO_SHORT,
    Reason("stop", "right shoulder (flexion)"),
    Reason("part", "instrument_panel"),
    Reason("words", "the seat's travel"),
)
LEVELS = (1, 5, 50, 95, 99)


def smaller_study(name, folder, *, people, detail="coarse"):
    """Write a shipped accommodation study with fewer people at another level of detail; returns its
    path."""
    text, counts = re.subn(
        r"people: \d+", f"people: {people}", (ROOT / "studies" / f"{name}.yaml").read_text()
    )
    text, details = re.subn(r"body: \w+,", rf"\g<0> detail: {detail},", text)
    assert (counts, details) == (1, 1)
    path = folder / f"{name}.yaml"
    path.write_text(text)
    return path


@cache
def trainer():
    return wb.load_environment("trainer")


def trainer_people(count, *, seed=7):
    """People like those of ANSUR II, called male 1 and so on."""
    return draw_people(wb.load_population_model("ansur2"), count, seed=seed, synthetic=True)


def study_of(people, criteria, *, maps=(), mixes=None):
    """The study of a population in the trainer's left seat, and the body of its people."""
    study = shipped_study()
    (role,) = study.roles
    body = wb.load_body("bubbleman")
    shares = replace(study.shares, mixes=mixes or {}, confidence=0.95)
    made_up = replace(
        study,
        name="made_up",
        title="Who fits the trainer",
        description="Made up for a test.",
        environment=trainer(),
        roles=(replace(role, body=body, detail=None, clothes=(), population=people),),
        criteria=criteria,
        shares=shares,
        reach_maps=maps,
        changes=(),
        inputs={},
    )
    return made_up, body


def groups_of(people, served, mixes, confidence, clear, sure=None):
    """clear: who fits and overlaps nothing; sure: who fits for certain, and who possibly; nothing is known if None."""
    rows = [
        ("everybody", np.ones(len(people), dtype=bool)),
        ("women", people.sex == 1),
        ("men", people.sex == 0),
    ]
    shares = []
    for name, mask in rows:
        if mask.any():
            found = proportion_interval(
                served[mask], weight=people.weight[mask], confidence=confidence
            )
            weight = people.weight[mask]
            ends = [float(weight @ some[mask] / weight.sum()) for some in sure or ()]
            count = int(mask.sum())
            row = GroupShare(name, found.share, found.low, found.high, count, *ends)
            shares.append(replace(row, clear=float(weight @ clear[mask] / weight.sum())))
    for name, women in mixes.items():
        parts = [(people.sex == 1, women), (people.sex == 0, 1 - women)]
        share = sum(
            part * float(np.mean(served[mask])) for mask, part in parts if part and mask.any()
        )
        shares.append(
            GroupShare(
                name, share, max(share - 0.03, 0), min(share + 0.03, 1), len(people), clear=share
            )
        )
    return tuple(shares)


def made(
    people,
    requirements,
    margin,
    *,
    mixes=None,
    maps=(),
    gains=(),
    warnings=(),
    shown=False,
    reason=None,
    less=0.0,
    more=0.0,
    overlapping=(),
    elsewhere=(),
):
    """An accommodation of margins (P, R) [m], all figures worked out from them in the plainest
    way. less, more [m]: how much lower and higher the margins of clearances may truly be;
    overlapping, elsewhere: rows of who overlaps something, and who fits for certain elsewhere."""
    margin = np.asarray(margin, dtype=float)
    surface = np.array([r.of_surface for r in requirements])
    low = margin - surface * less
    high = margin + surface * more
    met = np.isnan(margin) | (margin >= -1e-6)
    served = met.all(axis=1)
    sure = [~((end < -1e-6).any(axis=1)) for end in (low, high)]
    sure[0][list(elsewhere)] = True
    clear = np.array([p not in overlapping for p in range(len(people))]) & served
    weight = people.weight / people.weight.sum()
    joint = float(weight @ served)
    without = np.array(
        [weight @ np.delete(met, r, axis=1).all(axis=1) for r in range(margin.shape[1])]
    )
    lack = -np.where(np.isnan(margin), 0.0, margin).min(axis=1)
    order = np.argsort(-lack, kind="stable")
    hardest = tuple(int(p) for p in order if not served[p])[:5]
    names = dict.fromkeys(r.criterion for r in requirements)
    checks = {r.criterion: r.check for r in requirements}
    criteria = tuple(Criterion(n, checks[n], (), (), (), 0.0) for n in names)
    study, body = study_of(people, criteria, mixes=mixes, maps=tuple(m.task for m in maps))
    if reason is None:
        reason = np.where(met, -1, np.arange(margin.shape[1]) % len(REASONS))
    spread = np.full((margin.shape[1], 5), np.nan)
    for r in range(margin.shape[1]):
        known = margin[~np.isnan(margin[:, r]), r]
        if len(known):
            spread[r] = np.percentile(known, LEVELS)
    measures = ("thumb_tip_reach", "popliteal_height", "eye_height_sitting", "buttock_knee_length")
    worst = np.argmin(np.where(np.isnan(margin), np.inf, margin), axis=1)
    return PopulationFound(
        study,
        workplace_of(study, 0, study.environment),
        people,
        body,
        tuple(requirements),
        margin,
        low,
        high,
        reason,
        REASONS,
        np.zeros((len(people), 2)),
        np.zeros((len(people), 2)),
        np.full((len(people), 4), np.nan),
        sets_met(met, [r.criterion for r in requirements]),
        np.zeros((len(people), 0)),
        tuple("" if served[p] else measures[worst[p] % 4] for p in range(len(people))),
        groups_of(people, served, mixes or {}, 0.95, clear, None if np.isnan(less) else sure),
        np.array(weight @ met),
        without,
        without - joint,
        spread,
        hardest,
        tuple(TriedChange(gain) for gain in gains),
        tuple(maps),
        tuple(warnings),
        tuple(shown_of(body, p, int(worst[p]), requirements) for p in hardest) if shown else (),
        overlapping=np.isin(np.arange(len(people)), overlapping),
        elsewhere=np.isin(np.arange(len(people)), elsewhere),
    )


def sets_met(met, names):
    """Who meets everything but one requirement, and everything but those of one criterion."""
    without = [np.delete(met, r, axis=1).all(axis=1) for r in range(met.shape[1])]
    for name in dict.fromkeys(names):
        without.append(met[:, [n != name for n in names]].all(axis=1))
    return np.stack(without, axis=1)


def shown_of(body, row, requirement, requirements):
    """The body, seated, with its target where the requirement's control is."""
    environment = trainer()
    file, _ = load_postures(posture_path("bubbleman"), body)
    name = "seated" if "seated" in file.postures else next(iter(file.postures))
    pose = posture_pose(body, file, name)
    poses = wb.seat(body, pose, environment.seat("left")).poses
    placed = wb.place(body, poses)
    here = requirements[requirement]
    control = next((c for c in environment.controls if c.name == here.target), None)
    segment = body.segments.index("RHN")
    tip = tuple(float(v) for v in placed.world_from_segment[0, segment, :, 3])
    return Illustration(
        row,
        requirement,
        "flying",
        poses,
        placed,
        environment,
        "right hand" if here.check == "reach" else "right knee",
        control.at if control else None,
        tip if control else None,
    )


@cache
def panel_map(part="instrument_panel", *, count=600, seed=3):
    """Shares that fall with the distance from a point, over the side of a part that the sitter
    sees."""
    environment = trainer()
    k = environment.part_index(part)
    rng = np.random.default_rng(seed)
    points = []
    normals = []
    for f in range(environment.part_start[k], environment.part_start[k + 1]):
        if environment.normal[f, 0] > -0.5:
            continue
        corners = environment.vertices[
            environment.triangles[environment.triangle_start[f] : environment.triangle_start[f + 1]]
        ]
        area = (
            np.linalg.norm(
                np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
            )
            / 2
        )
        for corner, one in zip(corners, area, strict=True):
            for u, v in rng.random((max(1, round(one * count / 0.45)), 2)):
                u, v = (1 - u, 1 - v) if u + v > 1 else (u, v)
                points.append(corner[0] + u * (corner[1] - corner[0]) + v * (corner[2] - corner[0]))
                normals.append(environment.normal[f])
    points = np.array(points)
    away = np.linalg.norm(points - [0.45, 0.15, 0.75], axis=1)
    share = np.round(1 / (1 + np.exp((away - 0.42) / 0.035)), 3)
    flat = np.column_stack([-points[:, 1], points[:, 2]])
    return ReachMap(
        MapTask(part, "push", 2, "either", count), points, np.array(normals), flat, share
    )


def trainer_accommodation(count=200, *, maps=1, controls=None, seed=7, shown=True):
    """Margins that hang together with the people's measures, for all controls of the left seat and
    more."""
    people = trainer_people(count, seed=seed)
    rng = np.random.default_rng(seed)
    chosen = [c for c in trainer().controls if not c.name.startswith("right_")][:controls]
    stature = people.column("stature")
    reach = people.column("thumb_tip_reach")
    requirements = []
    columns = []
    away = [float(np.linalg.norm(np.array(c.at) - [0.1, 0.2, 0.8])) for c in chosen]
    for c, far in zip(chosen, np.argsort(np.argsort(away)) / max(len(chosen) - 1, 1), strict=True):
        criterion = f"controls of zone {c.zone}"
        requirements.append(Requirement(f"reach {c.name}", criterion, "reach", c.name, c.zone))
        columns.append(np.minimum(reach - 0.48 - 0.22 * far**3, 0.25) + rng.normal(0, 0.01, count))
    for name, target, margin in [
        ("right shin clear of the panel", "instrument_panel", 2.1 - stature),
        ("head clear of the canopy", "canopy", 1.02 - people.column("sitting_height") + 0.02),
        ("thighs clear of the stick", "left_stick", 0.27 - people.column("thigh_clearance")),
    ]:
        requirements.append(Requirement(name, "room to move", "clearance", target))
        columns.append(margin)
    requirements.append(
        Requirement("eyes at the height of the design eye", "view", "eye_height", "left_design_eye")
    )
    columns.append(0.09 - np.abs(people.column("eye_height_sitting") - 0.77))
    requirements.append(Requirement("pedals within the seat's travel", "seat", "pedals", "left"))
    columns.append(0.09 - np.abs(people.column("popliteal_height") - 0.42))
    gains = (
        DesignChange(
            "moving flaps 32 mm aft", "reach flaps", 0.032, 2.1, 0.881, 0.95, 0.813, 0.842
        ),
        DesignChange(
            "lengthening the seat's travel forward by 25 mm",
            "pedals within the seat's travel",
            0.025,
            1.0,
            0.97,
            0.99,
            0.813,
            0.813,
        ),
    )
    return made(
        people,
        requirements,
        np.stack(columns, axis=1),
        mixes={"half women": 0.5, "a quarter women": 0.25, "one in ten women": 0.1},
        maps=[panel_map()] * maps,
        gains=gains,
        warnings=["The population is one of soldiers."],
        shown=shown,
    )


@cache
def shipped_study():
    return wb.load_study("trainer_accommodation")


def result_of(found):
    """The result of a study of a population, made up of what was found of it."""
    provenance = {
        "inputs": {"study": "0" * 64},
        "people": {"measures": people_hash(found.people)},
        "versions": {"workbench": "0.1.0"},
    }
    return Result(found.study, (), found.warnings, provenance, population=found)


def few(result, rows):
    """The same for some of the people, worked out again."""
    people = result.people.rows(np.asarray(rows))
    again = made(people, result.requirements, result.margin[rows], maps=result.maps)
    return replace(again, tried=result.tried)
