"""Reach against ikpy, pink (Pinocchio) and mink (MuJoCo) on the right arm: success, error, CPU
time, on targets of legal postures; many people, a reach map and an envelope. Solvers that are not
installed are skipped (pip install ikpy pin-pink mink mujoco quadprog daqp).

python benchmarks/reach.py [TARGETS]
"""

from __future__ import annotations

import sys
import tempfile
import time

import numpy as np

import workbench as wb
from workbench.model.joint_angles import compose
from workbench.posture.reaching.limbs import limb
from workbench.posture.seating.posture import Pedals
from workbench.posture.stops import stops

WARM = 4


def legal_targets(body, arm, count):
    """Tip positions (count, 3) of legal postures drawn evenly from the joints' ranges, the base in
    place."""
    rng = np.random.default_rng(11)
    found = []
    free = list(arm.free)
    while sum(map(len, found)) < count:
        angles = np.zeros((4000, len(body.joints), 3))
        low = -body.stops.limits[free, :, 1]
        high = body.stops.limits[free, :, 0]
        angles[:, free] = rng.uniform(low, high, (4000, len(free), 3))
        poses = wb.Poses(
            compose(body, angles), arm.base, np.broadcast_to(np.eye(3, 4), (4000, 3, 4))
        )
        ok = stops(body, poses).margin[:, free].min(axis=1) >= 0
        world = wb.place(body, poses, window=[body.segments[arm.end]]).world_from_segment[
            ok, arm.end
        ]
        found.append(np.einsum("pij,j->pi", world[..., :3], arm.tip[0]) + world[..., 3])
    return np.concatenate(found)[:count]


def ikpy_chain(body, arm):
    """The same arm as ikpy knows arms: seven turns with their ranges as bounds, one after
    another."""
    from ikpy.chain import Chain
    from ikpy.link import OriginLink, URDFLink

    links = [OriginLink()]
    offset = None
    first = body.joint("RC")
    offset = body.joint_in_parent[0, first] - body.joint_in_child[0, first]
    for name in ("RS", "RE", "RW"):
        j = body.joint(name)
        at = offset + body.joint_in_parent[0, j]
        for axis in (0,) if name == "RE" else (0, 1, 2):
            high, low = body.stops.limits[j, axis]
            links.append(
                URDFLink(
                    f"{name}{axis}",
                    at,
                    [0, 0, 0],
                    list(body.stops.axes[j, axis]),
                    bounds=(-low, high),
                )
            )
            at = np.zeros(3)
        offset = -body.joint_in_child[0, j]
    links.append(URDFLink("tip", offset + arm.tip[0], [0, 0, 0], joint_type="fixed"))
    mask = [False, *[True] * (len(links) - 2), False]
    return Chain(links, active_links_mask=mask)


HINGE = '<joint name="{0}{1}" type="hinge" axis="{2} {3} {4}" range="{5} {6}" limited="true"/>'


def arm_model(body, arm):
    """The same arm as MuJoCo's XML: seven hinges with their ranges."""
    place = body.joint_in_parent[0, body.joint("RC")] - body.joint_in_child[0, body.joint("RC")]
    text = ""
    ends = ""
    for name in ("RS", "RE", "RW"):
        j = body.joint(name)
        x, y, z = place + body.joint_in_parent[0, j]
        text += f'<body name="{name}" pos="{x} {y} {z}"><inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>'
        for axis in (0,) if name == "RE" else (0, 1, 2):
            high, low = body.stops.limits[j, axis]
            text += HINGE.format(name, axis, *body.stops.axes[j, axis], -low, high)
        ends = ends + "</body>"
        place = -body.joint_in_child[0, j]
    x, y, z = place + arm.tip[0]
    tip = f'<body name="end" pos="{x} {y} {z}"><inertial pos="0 0 0" mass="0.1" diaginertia="0.01 0.01 0.01"/></body>'
    site = f'<site name="tip" pos="{x} {y} {z}"/>'
    return (
        f'<mujoco><compiler angle="radian"/><worldbody>{text}{site}{tip}{ends}</worldbody></mujoco>'
    )


def with_mink(body, arm, targets):
    """Gaps [m] that differential inverse kinematics with joint limits leaves after 200 steps at
    most."""
    import mink
    import mujoco

    model = mujoco.MjModel.from_xml_string(arm_model(body, arm))
    limits = [mink.ConfigurationLimit(model)]
    gaps = []
    for target in targets:
        state = mink.Configuration(model, q=np.clip(np.zeros(model.nq), *model.jnt_range.T))
        task = mink.FrameTask("tip", "site", position_cost=1.0, orientation_cost=0.0)
        task.set_target(mink.SE3.from_translation(target))
        gap = np.inf
        for _ in range(200):
            speed = mink.solve_ik(state, [task], 0.1, "daqp", damping=1e-6, limits=limits)
            state.integrate_inplace(speed, 0.1)
            gap = np.linalg.norm(
                state.get_transform_frame_to_world("tip", "site").translation() - target
            )
            if gap < 1e-5:
                break
        gaps.append(gap)
    return gaps


def with_pink(body, arm, targets):
    """The same with pink."""
    import pink
    import pinocchio

    model = _model_of(pinocchio, arm_model(body, arm))
    gaps = []
    for target in targets:
        state = pink.Configuration(model, model.createData(), pinocchio.neutral(model))
        task = pink.tasks.FrameTask("tip", position_cost=1.0, orientation_cost=0.0)
        task.set_target(pinocchio.SE3(np.eye(3), target))
        gap = np.inf
        for _ in range(200):
            speed = pink.solve_ik(state, [task], 0.1, solver="daqp", damping=1e-6)
            state.integrate_inplace(speed, 0.1)
            gap = np.linalg.norm(state.get_transform_frame_to_world("tip").translation - target)
            if gap < 1e-5:
                break
        gaps.append(gap)
    return gaps


def _model_of(pinocchio, text):
    """Pinocchio reads this format from files only."""
    with tempfile.NamedTemporaryFile("w", suffix=".xml") as file:
        file.write(text)
        file.flush()
        return pinocchio.buildModelFromMJCF(file.name)


def with_ikpy(body, arm, targets):
    """Gaps [m] that ikpy leaves."""
    chain = ikpy_chain(body, arm)
    start = np.zeros(len(chain.links))
    gaps = []
    for target in targets:
        solution = chain.inverse_kinematics(target, initial_position=start)
        gaps.append(np.linalg.norm(chain.forward_kinematics(solution)[:3, 3] - target))
    return gaps


def peers(body, arm, count):
    """One line for each solver that is installed."""
    targets = legal_targets(body, arm, count)
    for name, solve in (("ikpy", with_ikpy), ("pink", with_pink), ("mink", with_mink)):
        try:
            solve(body, arm, targets[:1])
        except ImportError as error:
            print(f"{name}: not installed ({error})")
            continue
        begun = time.process_time()
        gaps = np.array(solve(body, arm, targets))
        spent = time.process_time() - begun
        each = f"median {1000 * np.median(gaps):.4f} mm, {1e6 * spent / len(targets):.0f} us each"
        print(
            f"{name}, zone 1: {100 * np.mean(gaps < 1e-4):.1f} % of {len(targets)} to 0.1 mm (boxes for stops), {each}"
        )


def timed(work):
    """CPU seconds of the second call."""
    work()
    begun = time.process_time()
    work()
    return time.process_time() - begun


def around(bodies, seated, cab, seat):
    """CPU time [s] of a reach for each control of the left seat's hands, with obstacles and 200 mm
    to spare."""
    each = []
    middle = np.array(seat.srp)
    for control in cab.controls:
        if control.grip == "foot" or control.name.startswith("right"):
            continue
        hand = "left hand" if control.at[1] > middle[1] else "right hand"
        arm = wb.limb(bodies, hand, grip=control.grip, zone=control.zone)
        spent = timed(
            lambda at=control.at, arm=arm: wb.reach(
                bodies,
                seated.poses,
                [at],
                limb=arm,
                environment=cab,
                moving_parts=seat.moves,
                displacement=seated.shift,
                max_extension=0.2,
            )
        )
        each.append(spent / len(bodies))
    return np.array(each)


def crowd(count):
    """People of the median body, stretched at random, in the trainer's left seat: reaches, seats,
    map, envelope."""
    body = wb.load_body("bubbleman")
    cab = wb.load_environment("trainer")
    rng = np.random.default_rng(2)
    seat = cab.seat("left")
    bodies = [
        wb.scale(body, {"stature": float(s)})
        for s in np.clip(rng.normal(1.70, 0.09, count), 1.5, 1.9)
    ]
    poses = wb.join_poses(
        [
            wb.pose(one, {"LE": {"flexion": 60}, "RE": {"flexion": 60}}, reference="LT")
            for one in bodies
        ]
    )
    bodies = wb.stack_bodies(bodies)
    pedals = Pedals(
        {"left foot": (0.93, 0.365, 0.144), "right foot": (0.93, 0.195, 0.144)}, floor=0.0
    )
    eye = cab.points["left_design_eye"][2]
    spent = timed(lambda: wb.seat(bodies, poses, seat, eye=eye, pedals=pedals))
    print(f"seat: {1000 * spent / count:.1f} ms a person")
    seated = wb.seat(bodies, poses, seat, eye=eye, pedals=pedals)
    at = [control.at for control in cab.controls if control.grip == "grasp" and control.zone == 2]
    arm = wb.limb(bodies, "right hand", grip="grasp", zone=2)
    free = timed(lambda: wb.reach(bodies, seated.poses, at, limb=arm))
    far = timed(lambda: wb.reach(bodies, seated.poses, at, limb=arm, max_extension=0.2))
    kept = timed(
        lambda: wb.reach(
            bodies,
            seated.poses,
            at,
            limb=arm,
            environment=cab,
            moving_parts=seat.moves,
            displacement=seated.shift,
        )
    )
    each = [1e6 * spent / count / len(at) for spent in (free, far, kept)]
    print(
        "reach: {:.0f} us a reach, {:.0f} with 200 mm of extension, {:.0f} with obstacles".format(
            *each
        )
    )
    each = 1e6 * around(bodies, seated, cab, seat)
    print(
        f"reach, {len(each)} controls one by one, with obstacles and 200 mm of extension: "
        f"{np.median(each):.0f} us a reach in the median, {each.mean():.0f} in the mean"
    )
    some = timed(
        lambda: wb.reach_map(bodies, seated.poses, cab, "instrument_panel", points=500, zone=2)
    )
    print(f"reach_map: {1e6 * some / count / 500:.1f} us a point and person, either hand")
    one = wb.Poses(
        seated.poses.rotations[:1], seated.poses.reference, seated.poses.world_from_reference[:1]
    )
    for where, heeded in (("obstacles aside", None), ("obstacles", cab)):
        spent = timed(
            lambda heeded=heeded: wb.reach_envelope(
                bodies[0],
                one,
                seat.srp,
                name="right hand",
                grip="grasp",
                environment=heeded,
                levels=False,
            )
        )
        print(f"envelope of 15 degrees, {where}: {spent:.2f} s of CPU")


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
        print(
            f"reach, zone {zone}: {share:.2f} % of {count} reached, worst margin {margin:.4f} deg, {each}"
        )
    peers(body, limb(body, "right hand"), max(count // 10, 20))
    crowd(64)


if __name__ == "__main__":
    main()
