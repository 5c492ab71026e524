"""Collision and clearance against other libraries, on one workload: CPU time a pose on one core,
answers checked.

    python -m benchmarks.clearance [--sizes 2k 50k 500k] [--no-peers] [--write]

Every figure is the median of repeated runs in one process held to one core. Peers that are not
installed are left out with a note. --write puts the table into docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import datetime
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from importlib import metadata
from pathlib import Path

import numpy as np

import workbench as wb
from benchmarks.peers import PEERS, NoAnswerError
from benchmarks.workload import SIZES, cockpit, dense_body, seated_poses
from workbench.contact.batches import grouped_clearance
from workbench.contact.collide import collides, self_clearance
from workbench.contact.fields import field_of, packed_faces
from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.poses import Placed

POSES = 1000
Row = tuple[str, str, str, float, str]


def microseconds(work: Callable[[], object], poses: int, *, repeat: int = 7) -> float:
    """Median CPU time of a pose [us]; the first run, which compiles and builds, is not counted."""
    work()
    times = []
    for _ in range(repeat):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return 1e6 * float(np.median(times)) / poses


def brute_force(points: Floats, corners: Floats) -> Floats:
    """(n,) distance of points (n, 3) to the nearest of triangles (T, 3, 3), one point at a time,
    nothing clever."""
    a = corners
    side = np.roll(corners, -1, axis=1) - corners
    square = np.maximum((side**2).sum(-1), 1e-300)
    normal = np.cross(side[:, 0], side[:, 1])
    area = np.maximum((normal**2).sum(-1), 1e-300)
    out = np.empty(len(points))
    for i, x in enumerate(points):
        away = x - a
        along = np.clip((away * side).sum(-1) / square, 0, 1)
        edges = ((away - along[..., None] * side) ** 2).sum(-1).min(axis=1)
        over = np.all((np.cross(side, away) * normal[:, None]).sum(-1) >= 0, axis=1)
        height = (away[:, 0] * normal).sum(-1) ** 2 / area
        out[i] = np.sqrt(np.where(over, np.minimum(height, edges), edges).min())
    return out


def winding(x: Floats, corners: Floats) -> float:
    """Winding number of triangles (T, 3, 3) about a point: the sum of their solid angles."""
    a, b, c = np.moveaxis(corners - x, 1, 0)
    p, q, r = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    below = p * q * r + (a * b).sum(1) * r + (b * c).sum(1) * p + (c * a).sum(1) * q
    return float(np.arctan2((a * np.cross(b, c)).sum(1), below).sum() / (2 * np.pi))


def by_segment(placed: Placed, environment: Environment, *, threads: int | None = None) -> Floats:
    """(P, N) [m] clearance of each segment to the nearest of all parts."""
    parts = tuple(range(len(environment.parts)))
    return grouped_clearance(placed, environment, (parts,), threads=threads)[0][:, :, 0]


def checked(placed: Placed, environment: Environment, *, sample: int = 12) -> float:
    """Greatest error [m] of `by_segment` against brute force over a seeded sample of poses and
    segments."""
    distance = by_segment(placed, environment)
    body = placed.body
    assert np.array_equal(collides(placed, environment), (distance < -1e-9).any(axis=1))
    corners = environment.vertices[environment.triangles]
    ends = environment.triangle_start[environment.part_start]
    rng = np.random.default_rng(3)
    worst = 0.0
    touching = np.argwhere(distance < 0)
    picked = [
        *rng.choice(touching, sample // 2),
        *rng.choice(np.argwhere(np.isfinite(distance)), sample // 2),
    ]
    for p, n in picked:
        centres = placed.centres[p, body.spheres(n)]
        least = np.inf
        for k in range(len(environment.parts)):
            part = corners[ends[k] : ends[k + 1]]
            gap = brute_force(centres, part)
            if environment.solid[k]:
                gap *= [-1.0 if abs(winding(c, part)) > 0.5 else 1.0 for c in centres]
            least = min(least, float((gap - body.radius[0, body.spheres(n)]).min()))
        worst = max(worst, abs(least - distance[p, n]))
    return worst


def ours(size: str, placed: Placed) -> Iterator[Row]:
    """This project's figures for one environment and body."""
    environment = cockpit(size)
    count = str(len(placed.body.sphere_names))
    hits = collides(placed, environment)
    yield (
        "any",
        size,
        count,
        microseconds(lambda: collides(placed, environment), POSES),
        f"{hits.mean():.0%} collide",
    )
    took = microseconds(lambda: by_segment(placed, environment), POSES)
    yield "by segment", size, count, took, f"error {1e3 * checked(placed, environment):.0e} mm"
    rows = len(wb.contacts(placed, environment))
    took = microseconds(lambda: wb.contacts(placed, environment), POSES, repeat=3)
    yield "contacts", size, count, took, f"{rows / POSES:.0f} a pose"
    few = Placed(placed.body, placed.world_from_segment[:100], placed.centres[:100], placed.window)
    took = microseconds(lambda: wb.clearance(few, environment), 100, repeat=3)
    yield "by segment and part", size, count, took, f"{len(environment.parts)} parts"


def of_the_body(placed: Placed) -> Iterator[Row]:
    """Figures that need no environment."""
    body = placed.body
    count = str(len(body.sphere_names))
    poses = seated_poses(body, 500)
    took = microseconds(lambda: wb.place(body, poses), len(poses))
    yield "forward kinematics and spheres", "", count, took, ""
    yield (
        "self clearance",
        "",
        count,
        microseconds(lambda: self_clearance(placed), POSES, repeat=3),
        "all pairs",
    )


def built(size: str) -> Iterator[Row]:
    """CPU milliseconds for the index of all parts together, its memory, and for reading it from
    disk."""
    environment = cockpit(size)
    groups = (tuple(range(len(environment.parts))),)
    for name in ("index made, ms", "index read, ms"):
        packed_faces(environment)
        field_of.cache_clear()
        begin = time.process_time()
        field = field_of(environment, groups)
        took = time.process_time() - begin
        memory = sum(values.nbytes for values in (*field, *packed_faces(environment))) / 1e6
        yield name, size, "", 1e3 * took, f"{memory:.0f} MB, {len(environment.triangles)} triangles"


def on_two_cores(placed: Placed) -> Iterator[Row]:
    """How much faster two threads are than one by the clock, which means little where others use
    the machine, and how much CPU time they take together, which should be that of one: what is more
    is theirs, the rest is the machine's."""
    environment = cockpit("50k")
    many = Placed(
        placed.body,
        *(np.repeat(values, 8, axis=0) for values in (placed.world_from_segment, placed.centres)),
        placed.window,
    )
    for name, ask, bodies in (("any", collides, many), ("by segment", by_segment, placed)):
        clock = {1: np.inf, 2: np.inf}
        spent = {1: np.inf, 2: np.inf}
        for _ in range(9):
            for threads in (1, 2):
                begin = time.perf_counter()
                began = time.process_time()
                ask(bodies, environment, threads=threads)
                clock[threads] = min(clock[threads], time.perf_counter() - begin)
                spent[threads] = min(spent[threads], time.process_time() - began)
        note = f"{clock[1] / clock[2]:.2f} times one by the clock, {spent[2] / spent[1]:.2f} times its CPU time"
        note += f", load {os.getloadavg()[0]:.1f}"
        yield (
            f"{name}, two cores",
            "50k",
            str(len(placed.body.sphere_names)),
            1e6 * clock[2] / len(bodies),
            note,
        )


COLD = """
import time
begin = time.process_time()
import workbench as wb
body = wb.load_body("bubbleman")
import benchmarks.workload as w
placed = wb.place(body, w.seated_poses(body, 100))
middle = time.process_time()
environment = w.cockpit("50k")
made = time.process_time()
wb.collides(placed, environment)
end = time.process_time()
print(end - begin - (made - middle))
"""


def cold() -> Iterator[Row]:
    """CPU time to the first answer in a new process, all imports in it, without the making of the
    mesh; caches warm."""
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", COLD], capture_output=True, text=True, check=True
        )
    yield (
        "first answer in a new process, ms",
        "50k",
        "399",
        1e3 * float(done.stdout),
        "CPU time, caches warm",
    )


def theirs(size: str, placed: Placed) -> Iterator[Row]:
    """The peers' figures on as many poses as take a few seconds; their answers beside ours."""
    environment = cockpit(size)
    hit = collides(placed, environment)
    distance = by_segment(placed, environment)
    for name, prepare in PEERS.items():
        try:
            ask = prepare(environment, placed)
        except ImportError as error:
            yield name, size, str(len(placed.body.sphere_names)), float("nan"), f"skipped: {error}"
            continue
        for kind, wanted in (("any", hit), ("by segment", distance)):
            try:
                ask(kind, 0)
            except NoAnswerError as error:
                yield (
                    f"{name}: {kind}",
                    size,
                    str(len(placed.body.sphere_names)),
                    float("nan"),
                    str(error),
                )
                continue
            spent = 0.0
            answers = []
            while spent < 3.0 and len(answers) < POSES:
                begin = time.process_time()
                answer = ask(kind, len(answers))
                spent += time.process_time() - begin
                answers.append(answer())
            told = agreement(kind, np.array(answers), wanted[: len(answers)])
            yield (
                f"{name}: {kind}",
                size,
                str(len(placed.body.sphere_names)),
                1e6 * spent / len(answers),
                told,
            )


def agreement(kind: str, answers: Floats, wanted: Floats) -> str:
    """How far a peer's answers are ours, where nothing is inside a solid (no peer here knows
    solids)."""
    if kind == "any":
        wrong = int(np.sum(answers != wanted))
        return f"{np.mean(answers == wanted):.1%} of {len(answers)} agree" + (
            f", {wrong} wrong" if wrong else ""
        )
    clear = np.isfinite(wanted) & (wanted > 0)
    return f"{1e3 * np.abs(answers[clear] - wanted[clear]).max(initial=0.0):.0e} mm where clear, {len(answers)} poses"


def table(rows: list[Row]) -> str:
    """The rows as a Markdown table."""
    lines = ["| figure | triangles | spheres | us a pose | |", "|---|---|---|---|---|"]
    for name, size, count, took, note in rows:
        lines.append(f"| {name} | {size} | {count} | {took:.3g} | {note} |")
    return "\n".join(lines)


def machine() -> str:
    """Where and with what the figures were taken."""
    names = ("numpy", "numba", *PEERS)
    found = {d.metadata["Name"].lower(): d.version for d in metadata.distributions()}
    versions = ", ".join(f"{name} {found[name]}" for name in names if name in found)
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    model = next(
        (line.split(": ")[1] for line in lines if line.startswith("model name")),
        platform.processor(),
    )
    python = f"Python {platform.python_version()}, {versions}"
    return f"{datetime.date.today()}, {model}, one of {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, {python}"


def main() -> None:
    """Take the figures and print one table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", nargs="+", choices=SIZES, default=list(SIZES))
    parser.add_argument("--no-peers", action="store_true")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks.md")
    asked = parser.parse_args()
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    body = wb.load_body("bubbleman")
    bodies = [wb.place(b, seated_poses(b, POSES, spread=1.15)) for b in (body, dense_body(body))]
    os.environ.setdefault("WORKBENCH_CACHE", tempfile.mkdtemp())
    rows: list[Row] = [row for placed in bodies for row in of_the_body(placed)]
    for size in asked.sizes:
        rows += list(built(size)) + [row for placed in bodies for row in ours(size, placed)]
        if size == "50k" and not asked.no_peers:
            rows += [row for placed in bodies for row in theirs(size, placed)]
    os.sched_setaffinity(0, cores)
    rows += [*on_two_cores(bodies[1]), *cold()]
    text = f"# Benchmarks\n\n{machine()}.\nMade by `python -m benchmarks.clearance --write`.\n\n{table(rows)}\n"
    print(text)
    if asked.write:
        (Path(__file__).parents[1] / "docs" / "benchmarks.md").write_text(text)


if __name__ == "__main__":
    main()
