"""Reach against ikpy on the right arm (pip install ikpy): success, error, CPU time, on targets of legal postures.

python benchmarks/reach.py [TARGETS]
"""

from __future__ import annotations

import sys
import time

import numpy as np

import workbench as wb
from workbench.model.posing import compose
from workbench.solve.limbs import limb
from workbench.solve.stops import stops

WARM = 4


def legal_targets(body, arm, count):
    """Tip positions (count, 3) of legal postures drawn evenly from the joints' ranges, the base in place."""
    rng, found = np.random.default_rng(11), []
    free = list(arm.free)
    while sum(map(len, found)) < count:
        angles = np.zeros((4000, len(body.joints), 3))
        low, high = -body.stops.limits[free, :, 1], body.stops.limits[free, :, 0]
        angles[:, free] = rng.uniform(low, high, (4000, len(free), 3))
        poses = wb.Poses(compose(body, angles), arm.base, np.broadcast_to(np.eye(3, 4), (4000, 3, 4)))
        ok = stops(body, poses).margin[:, free].min(axis=1) >= 0
        world = wb.place(body, poses, window=[body.segments[arm.end]]).world_from_segment[ok, arm.end]
        found.append(np.einsum("pij,j->pi", world[..., :3], arm.tip) + world[..., 3])
    return np.concatenate(found)[:count]


def ikpy_chain(body, arm):
    """The same arm as ikpy knows arms: seven turns with their ranges as bounds, one after another."""
    from ikpy.chain import Chain
    from ikpy.link import OriginLink, URDFLink

    links, offset = [OriginLink()], None
    first = body.joint("RC")
    offset = body.joint_in_parent[first] - body.joint_in_child[first]
    for name in ("RS", "RE", "RW"):
        j = body.joint(name)
        at = offset + body.joint_in_parent[j]
        for axis in (0,) if name == "RE" else (0, 1, 2):
            high, low = body.stops.limits[j, axis]
            links.append(URDFLink(f"{name}{axis}", at, [0, 0, 0], list(body.stops.axes[j, axis]), bounds=(-low, high)))
            at = np.zeros(3)
        offset = -body.joint_in_child[j]
    links.append(URDFLink("tip", offset + arm.tip, [0, 0, 0], joint_type="fixed"))
    mask = [False, *[True] * (len(links) - 2), False]
    return Chain(links, active_links_mask=mask)


def main():
    """Print one line for each solver."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    body = wb.load_body("bubbleman")
    held = wb.pose(body, {}, reference="UT")
    for zone in (1, 2, 3):
        arm = limb(body, "right hand", zone=zone)
        targets = legal_targets(body, arm, count)
        held = wb.pose(body, {}, reference=body.segments[arm.base])
        wb.reach(body, held, targets[:WARM], limb=arm)
        times = []
        for target in targets[: min(count, 200)]:
            begun = time.process_time()
            wb.reach(body, held, target, limb=arm)
            times.append(time.process_time() - begun)
        begun = time.process_time()
        found = wb.reach(body, held, targets, limb=arm)
        spent = time.process_time() - begun
        margin = np.degrees(stops(body, found.poses).margin[:, list(arm.free)].min())
        each = f"{1e6 * spent / count:.0f} us each in a batch, {1e6 * np.median(times):.0f} us median one by one"
        share = 100 * found.reached.mean()
        print(f"reach, zone {zone}: {share:.2f} % of {count} reached, worst margin {margin:.4f} deg, {each}")
    arm = limb(body, "right hand")
    targets = legal_targets(body, arm, count)[: max(count // 10, 20)]
    chain = ikpy_chain(body, arm)
    start = np.zeros(len(chain.links))
    begun, gaps = time.process_time(), []
    for target in targets:
        solution = chain.inverse_kinematics(target, initial_position=start)
        gaps.append(np.linalg.norm(chain.forward_kinematics(solution)[:3, 3] - target))
    spent = time.process_time() - begun
    each = f"median {1000 * np.median(gaps):.4f} mm, {1e6 * spent / len(targets):.0f} us each"
    share = 100 * np.mean(np.array(gaps) < 1e-4)
    print(f"ikpy, zone 1: {share:.2f} % of {len(targets)} to 0.1 mm (boxes for stops), {each}")


if __name__ == "__main__":
    main()
