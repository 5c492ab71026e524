"""Clearance and collision on an NVIDIA card, beside the processor, on the workload of the other
benchmarks.

    python -m benchmarks.gpu [--size 50k] [--spheres 1500] [--poses 1000000]

Needs numba-cuda and a card. Answers are compared with the processor's on the first 2,000 poses
before anything is timed. Times are wall-clock, the least of three after one run to compile, and
hold the transfers to and from the card.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

import workbench as wb
from benchmarks.workload import SIZES, cockpit, dense_body, seated_poses
from workbench.contact.collide import by_segment
from workbench.contact.posed import posed_collides
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Poses

CHECKED = 2000


def _seconds(work: Callable[[], object]) -> float:
    work()
    best = np.inf
    for _ in range(3):
        begin = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - begin)
    return best


def _some(poses: Poses, count: int) -> Poses:
    return Poses(poses.rotations[:count], poses.reference, poses.world_from_reference[:count])


def _agree(body: Body, poses: Poses, environment: Environment) -> None:
    """Leave with a message where the card's answers are not the processor's."""
    placed = wb.place(body, _some(poses, CHECKED))
    one = by_segment(placed, environment)
    two = by_segment(placed, environment, device="cuda")
    known = np.isfinite(one.distance)
    worst = float(np.max(np.abs(one.distance[known] - two.distance[known])))
    hits = wb.collides(placed, environment)
    same = np.array_equal(hits, wb.collides(placed, environment, device="cuda"))
    same = same and np.array_equal(
        hits, posed_collides(body, _some(poses, CHECKED), environment, device="cuda")
    )
    print(
        f"{len(hits)} poses, {hits.mean():.0%} collide; clearance differs by at most {worst:.1e} m"
    )
    if worst > 1e-5 or not same:
        raise SystemExit("the card's answers are not the processor's")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--size", choices=list(SIZES), default="50k")
    parser.add_argument("--spheres", type=int, default=1500)
    parser.add_argument("--poses", type=int, default=1_000_000)
    asked = parser.parse_args()
    environment = cockpit(asked.size)
    body = dense_body(wb.load_body("bubbleman"), asked.spheres)
    poses = seated_poses(body, asked.poses)
    few = _some(poses, min(asked.poses, 20_000))
    placed = wb.place(body, few)
    _agree(body, poses, environment)
    cases: list[tuple[str, int, Callable[[], object]]] = [
        ("processor: any, placed", len(few), lambda: wb.collides(placed, environment)),
        (
            "card: any, placed and moved there",
            len(few),
            lambda: wb.collides(placed, environment, device="cuda"),
        ),
        (
            "card: any, placed on the card",
            len(poses),
            lambda: posed_collides(body, poses, environment, device="cuda"),
        ),
        ("processor: by segment, placed", len(few), lambda: by_segment(placed, environment)),
        (
            "card: by segment, placed and moved",
            len(few),
            lambda: by_segment(placed, environment, device="cuda"),
        ),
    ]
    print(f"{body}, {environment}")
    for name, count, work in cases:
        seconds = _seconds(work)
        print(
            f"{name:38s} {count:9d} poses {seconds:9.3f} s {1e6 * seconds / count:9.3f} us a pose "
            f"{count / seconds:12.0f} a second"
        )


if __name__ == "__main__":
    main()
