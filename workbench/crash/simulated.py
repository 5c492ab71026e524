"""Simulate a crash: the occupant settles in the seat, then the pulse acts.

The model is coarse: rigid segments, and springs for flesh and foam. The reference frame is the
vehicle's, so its deceleration acts on the occupant as a body force in the direction of travel.
MuJoCo integrates with a fixed step; forces of stops, contacts and belts are those at its beginning.
The same inputs give the same bytes on the same machine.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from workbench.body.forward import place
from workbench.crash.contacts import ContactMemory, SegmentForce, contact_forces
from workbench.crash.mass_properties import (
    CompositeBody,
    composite_bodies,
    root_segment,
    segment_inertia,
    segment_masses,
)
from workbench.errors import InputError, MissingPartError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.poses import Placed, Poses
from workbench.model.quaternions import conjugate, from_matrices, matrices, multiply
from workbench.model.simulation import (
    STANDARD_GRAVITY,
    Belt,
    Simulated,
    Simulation,
    force_at,
    level_at,
)
from workbench.posture.kernels.limit_violation import StopPack, past_stops
from workbench.posture.stops import packed_stops

__all__ = [
    "STOP_SOFTNESS",
    "MechanicalProperties",
    "import_mujoco",
    "joint_springs",
    "model_text",
    "simulate",
    "stop_moments",
]

_STOP_LOAD = 20.0
"""Reference moment of a joint stop, as a multiple of the weight moment that the joint carries."""
_MIN_STOP_LEVER = 0.04
"""Lever [m] of the body's weight for the least reference moment: hands are light, but wrists are
not weak."""
_SETTLING_STIFFNESS = 30.0
"""Factor on the stiffness of joints while the occupant settles, so that the posture is kept."""
_SETTLING_DECAY = 40.0
"""Rate [1/s] at which all speeds decay while the occupant settles."""
_SETTLED_SPEED = 0.004
"""Root mean square speed [m/s] below which the occupant is at rest."""
_MIN_SETTLING = 0.1
"""Least time [s] of settling, since a body is slow at the start too."""
_SETTLING_STEP = 5e-4
"""Greatest step [s] while settling, unless the crash's own step is longer."""
_DIVERGED_SPEED = 3.0
"""Root mean square speed [m/s] that no occupant has who settles: the integration has diverged."""
_ENERGY_MARGIN = 1.1
_STORED_ENERGY = 25.0
"""Energy [J] that springs of seat and flesh may hold at the start and give back."""


def simulate(simulation: Simulation) -> Simulated:
    """Simulate a crash from settling in the seat to the end of the given duration.

    Returns
    -------
    Simulated
        The motion in the vehicle's frame, belt forces and energies, one row a frame.

    Raises
    ------
    MissingPartError
        If MuJoCo is not installed.
    InputError
        If the body has no mass, or the step is too long for the forces.
    """
    crash = _Crash(simulation, import_mujoco())
    remaining_speed = crash.settle()
    return crash.run(remaining_speed)


class _Belts:
    """The belts of a simulation. They pull once they are fastened."""

    def __init__(self, belts: tuple[Belt, ...]) -> None:
        self.belts = belts
        self.fastened = False
        self.start_length = np.zeros(len(belts))
        self.max_stretch = np.zeros(len(belts))
        """Greatest elongations [m] so far, for the unloading branch of the force law."""

    def fasten(self, length: Floats) -> None:
        """Take the lengths (B,) [m] as those without elongation."""
        self.fastened = True
        self.start_length = length.copy()

    def elongations(self, length: Floats) -> Floats:
        """(B,) [m] by which belts of lengths (B,) [m] are longer than at the start."""
        return np.asarray(length - self.start_length)

    def tensions(self, length: Floats) -> Floats:
        """(B,) [N] of belts of lengths (B,) [m]; zero before they are fastened."""
        tension = np.zeros(len(self.belts))
        if not self.fastened:
            return tension
        for b, belt in enumerate(self.belts):
            stretch = float(length[b] - self.start_length[b]) - belt.slack
            tension[b] = force_at(belt.law, stretch, self.max_stretch[b])
            self.max_stretch[b] = max(self.max_stretch[b], stretch)
        return tension


@dataclass(frozen=True, eq=False)
class _History:
    """What is recorded of P frames."""

    state: Floats
    """(P, Q) MuJoCo's coordinates."""
    tension: Floats
    """(P, B) [N] of the belts."""
    payout: Floats
    """(P, B) [m] of the belts."""
    kinetic: Floats
    """(P,) [J]."""
    work: Floats
    """(P,) [J] of pulse and gravity."""

    @classmethod
    def empty(cls, frames: int, coordinates: int, belts: int) -> _History:
        return cls(
            np.empty((frames, coordinates)),
            np.zeros((frames, belts)),
            np.zeros((frames, belts)),
            np.zeros(frames),
            np.zeros(frames),
        )


class _Crash:
    """The state of a simulation: MuJoCo's model and data, contacts and belts."""

    def __init__(self, simulation: Simulation, mujoco: ModuleType) -> None:
        body = simulation.body
        start = place(body, simulation.poses)
        mass = segment_masses(body)
        inertia = segment_inertia(body, mass)
        loads = composite_bodies(start, mass, inertia)
        properties = MechanicalProperties(mass, inertia, *joint_springs(simulation, loads))
        self.simulation = simulation
        self.mujoco = mujoco
        self.model: Any = mujoco.MjModel.from_xml_string(model_text(simulation, properties))
        self.data: Any = mujoco.MjData(self.model)
        self.root = root_segment(body)
        self.joints = np.arange(self.root, len(body.joints))
        """Joints of the model: those beyond the root segment."""
        self.mass = float(mass[self.root :].sum())
        self.stops = packed_stops(body)
        self.stop_moment = _stop_moment(loads, self.mass)
        self.contacts = ContactMemory.at_start(simulation, start)
        self.belts = _Belts(simulation.belts)
        stage = start.world_from_segment[:, max(self.root - 1, 0), :, :3]
        self.stage_from_world = conjugate(from_matrices(stage))
        self.posture_force = np.zeros(self.model.nv)
        """Generalized force that held the posture when settling ended."""
        self.work = 0.0
        """Work [J] of pulse and gravity on the occupant since the start of the crash."""
        self.data.qpos[:] = self._coordinates(start)
        self.model.qpos_spring[:] = self.data.qpos

    def _coordinates(self, start: Placed) -> Floats:
        """MuJoCo's coordinates of the posture: position and quaternion of the root, then joints."""
        world = start.world_from_segment[0, self.root]
        rotation = from_matrices(world[None, :, :3])[0]
        joints = self.simulation.poses.rotations[0, self.joints]
        return np.concatenate([world[:, 3], rotation, joints.ravel()])

    def settle(self) -> float:
        """Bring the occupant to rest in the seat without belts.

        Returns
        -------
        float
            Remaining root mean square speed [m/s].
        """
        longest = self.simulation.settle
        shortest = min(_MIN_SETTLING, longest)
        step = max(self.simulation.step, min(_SETTLING_STEP, 2.5 * self.simulation.step))
        gravity = np.array([0.0, 0.0, -self.simulation.gravity])
        time = 0.0
        speed = 0.0
        self._scale_stiffness(_SETTLING_STIFFNESS)
        self.model.opt.timestep = step
        while time < longest:
            self._step(gravity)
            if self._kinetic_energy() > 0.5 * self.mass * _DIVERGED_SPEED**2:
                raise _step_too_long(self.simulation, "while the occupant settles")
            self.data.qvel[:] *= np.exp(-_SETTLING_DECAY * step)
            time += step
            speed = float(np.sqrt(2.0 * max(self._kinetic_energy(), 0.0) / self.mass))
            if speed < _SETTLED_SPEED and time >= shortest:
                break
        self._start_crash()
        return speed

    def _start_crash(self) -> None:
        """Stop all motion, keep the posture's forces, and fasten the belts."""
        self.data.qvel[:] = 0.0
        self.data.time = 0.0
        self.model.opt.timestep = self.simulation.step
        self.mujoco.mj_forward(self.model, self.data)
        # muscles keep the force that holds the posture: a crash is shorter than a reaction time
        self.posture_force = self.data.qfrc_passive.copy()
        self._scale_stiffness(1.0 / _SETTLING_STIFFNESS)
        self.model.qpos_spring[:] = self.data.qpos
        self.belts.fasten(self.data.ten_length)
        self.work = 0.0

    def _scale_stiffness(self, factor: float) -> None:
        """Multiply the stiffness of the joints that hold the posture, at one damping ratio.

        Critical damping is proportional to the square root of the stiffness.
        """
        held = np.isin(self.joints, self.simulation.relaxed, invert=True)
        self.model.jnt_stiffness[1:][held] *= factor  # joint 0 is the root's free joint
        self.model.dof_damping[6:][np.repeat(held, 3)] *= np.sqrt(factor)

    def run(self, remaining_speed: float) -> Simulated:
        """Simulate the crash itself and record one frame every `frame` seconds."""
        simulation = self.simulation
        steps = max(round(simulation.frame / simulation.step), 1)
        interval = steps * simulation.step
        frames = int(np.floor(simulation.duration / interval + 1e-9)) + 1
        history = _History.empty(frames, len(self.data.qpos), len(simulation.belts))
        for frame in range(frames):
            history.state[frame] = self.data.qpos
            for step in range(steps):
                time = (frame * steps + step) * simulation.step
                self._step(self._body_force(time))
                if step == 0:
                    self._record(history, frame)
                self._check_energy(time)
        return Simulated(
            self._motion(history.state, interval),
            history.tension,
            history.payout,
            history.kinetic,
            history.work,
            remaining_speed,
            _warnings(simulation, remaining_speed),
        )

    def _record(self, history: _History, frame: int) -> None:
        """Record belts and energies; after a step they are those at its beginning."""
        history.tension[frame] = -self.data.ctrl
        history.payout[frame] = self.belts.elongations(self.data.ten_length)
        history.kinetic[frame] = self._kinetic_energy()
        history.work[frame] = self.work

    def _body_force(self, time: float) -> Floats:
        """(3,) [m/s2] gravity and the inertial force of the pulse, per unit of mass."""
        pulse = self.simulation.pulse
        gravity = np.array([0.0, 0.0, -self.simulation.gravity])
        return gravity + np.array(pulse.toward) * float(level_at(pulse, np.array([time]))[0])

    def _step(self, body_force: Floats) -> None:
        """Advance by one step under a body force (3,) [m/s2]."""
        mujoco = self.mujoco
        self.model.opt.gravity[:] = body_force
        mujoco.mj_step1(self.model, self.data)  # positions and velocities
        before = self.data.subtree_com[1].copy()
        self._apply_loads()
        mujoco.mj_step2(self.model, self.data)  # accelerations and integration
        if not np.isfinite(self.data.qpos).all() or not np.isfinite(self.data.qvel).all():
            raise _step_too_long(self.simulation, f"at {1000 * float(self.data.time):.1f} ms")
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        # a uniform body force does work on the centre of gravity alone
        displacement = self.data.subtree_com[1] - before
        self.work += self.mass * float(body_force @ displacement)

    def _apply_loads(self) -> None:
        """Apply joint stops, contacts and belts, as of the model's present state."""
        pose = self._pose()
        self.data.qfrc_applied[:] = self.posture_force
        self._apply_stops(pose.rotations[0])
        for contact in contact_forces(self.contacts, place(self.simulation.body, pose)):
            self._apply_contact(contact)
        self.data.ctrl[:] = -self.belts.tensions(self.data.ten_length)

    def _apply_stops(self, rotations: Floats) -> None:
        """Apply the moments of the stops at joint rotations (J, 4)."""
        rates = np.zeros((len(rotations), 3))
        rates[self.joints] = self.data.qvel[6:].reshape(-1, 3)
        moments = stop_moments(self.stops, rotations, rates, self.stop_moment)
        self.data.qfrc_applied[6:] += moments[self.joints].ravel()

    def _apply_contact(self, contact: SegmentForce) -> None:
        """Apply a contact's force to its segment, and the opposite to the other one."""
        sliding = np.zeros(3)
        if contact.friction > 0:
            sliding = self._velocity(contact.segment, contact.point)
        if contact.friction > 0 and contact.other >= 0:
            sliding = sliding - self._velocity(contact.other, contact.point)
        force = contact.with_friction(sliding)
        self._apply_force(contact.segment, contact.point, force)
        if contact.other >= 0:
            self._apply_force(contact.other, contact.point, -force)

    def _model_body(self, segment: int) -> int:
        """The number of a segment in the model, whose body 0 is the world."""
        return segment - self.root + 1

    def _velocity(self, segment: int, point: Floats) -> Floats:
        """(3,) [m/s] of a point (3,) [m] that moves with a segment, v + w x r."""
        twist = np.empty(6)  # angular, then linear velocity, in the world's axes
        body = self._model_body(segment)
        kind = self.mujoco.mjtObj.mjOBJ_XBODY
        self.mujoco.mj_objectVelocity(self.model, self.data, kind, body, twist, 0)
        # written out: np.cross takes ten times as long for one vector
        a, b, c = twist[:3].tolist()
        x, y, z = (point - self.data.xpos[body]).tolist()
        return np.asarray(twist[3:] + np.array([b * z - c * y, c * x - a * z, a * y - b * x]))

    def _apply_force(self, segment: int, point: Floats, force: Floats) -> None:
        """Add a force (3,) [N] at a point (3,) [m] of a segment."""
        body = self._model_body(segment)
        torque = np.zeros(3)
        applied = self.data.qfrc_applied
        self.mujoco.mj_applyFT(self.model, self.data, force, torque, point, body, applied)

    def _pose(self) -> Poses:
        """The pose of the model's present state."""
        rotations = self.simulation.poses.rotations.copy()
        joints = self.data.qpos[7:].reshape(-1, 4)
        rotations[0, self.joints] = joints / np.sqrt(np.sum(joints * joints, axis=1))[:, None]
        body = self._model_body(self.root)
        world = np.concatenate(
            [self.data.xmat[body].reshape(3, 3), self.data.xpos[body][:, None]], axis=1
        )
        return Poses(rotations, self.root, world[None])

    def _motion(self, states: Floats, interval: float) -> Poses:
        """The recorded states (P, Q), one every `interval` seconds, as a motion."""
        rotations = np.repeat(self.simulation.poses.rotations, len(states), axis=0)
        joints = states[:, 7:].reshape(len(states), -1, 4)
        rotations[:, self.joints] = joints / np.linalg.norm(joints, axis=-1, keepdims=True)
        root = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=-1, keepdims=True)
        if self.root:  # the stage before the root segment keeps its attitude
            stage = np.tile(self.stage_from_world, (len(states), 1))
            rotations[:, self.root - 1] = multiply(stage, root)
        world = np.concatenate([matrices(root), states[:, :3, None]], axis=-1)
        time = np.round(np.arange(len(states)) * interval, 9)
        return Poses(rotations, self.root, world, time)

    def _kinetic_energy(self) -> float:
        return float(self.data.energy[1])

    def _check_energy(self, time: float) -> None:
        """Compare the kinetic energy with the work of pulse and gravity, which it cannot exceed."""
        limit = _ENERGY_MARGIN * max(self.work, 0.0) + _STORED_ENERGY
        if self._kinetic_energy() > limit:
            raise _step_too_long(self.simulation, f"at {1000 * time:.1f} ms")


def _step_too_long(simulation: Simulation, when: str) -> InputError:
    """The error of a step in which the occupant gains energy."""
    step = 1000 * simulation.step
    return InputError(
        f"simulation {simulation.name}: the step of {step:g} ms is too coarse: {when} the "
        f"occupant has more energy than he was given; try 'step: {step / 4:g}'"
    )


def _warnings(simulation: Simulation, remaining_speed: float) -> tuple[str, ...]:
    """A warning if the occupant was not at rest at the start; speed [m/s]."""
    if simulation.settle <= 0 or remaining_speed < 5 * _SETTLED_SPEED:
        return ()
    return (
        f"the occupant still moved at {1000 * remaining_speed:.0f} mm/s when settling ended after "
        f"{1000 * simulation.settle:g} ms",
    )


def _stop_moment(loads: CompositeBody, mass: float) -> Floats:
    """(J,) [Nm] reference moments of the joint stops of an occupant of a mass [kg]."""
    load = np.maximum(_STOP_LOAD * loads.mass * loads.lever, _MIN_STOP_LEVER * mass)
    return np.asarray(STANDARD_GRAVITY * load)


# Write a sphere body and its belts as a MuJoCo model [1]_.
#
# Segments are a tree of rigid bodies on ball joints, belts are spatial tendons. MuJoCo computes the
# dynamics of the tree and the geometry of the tendons. Contacts and joint stops are applied forces:
# the stiffness of MuJoCo's soft constraints scales with the mass, so a stiffness in N/mm cannot be
# given to them, and its collision detection needs convex parts. Spheres are geoms for display only.
#
# References
# ----------
# .. [1] E. Todorov, T. Erez & Y. Tassa (2012), MuJoCo: A physics engine for model-based control,
#    IEEE/RSJ International Conference on Intelligent Robots and Systems, 5026-5033.

_DAMPING_RATIO = 0.3
"""Damping of a joint, as a share of the critical damping for its stiffness and inertia."""


@dataclass(frozen=True, eq=False)
class MechanicalProperties:
    """Masses of N segments, and springs of J joints."""

    mass: Floats
    """(N,) [kg]."""
    inertia: Floats
    """(N, 3, 3) [kg m2] about each segment's origin."""
    stiffness: Floats
    """(J,) [Nm/rad]."""
    damping: Floats
    """(J,) [Nm s/rad]."""


def import_mujoco() -> ModuleType:
    """Import MuJoCo.

    Raises
    ------
    MissingPartError
        If it is not installed.
    """
    try:
        import mujoco
    except ImportError:
        raise MissingPartError(
            "simulated crashes need MuJoCo: pip install 'bubbleman-workbench[dynamics]' (stored motions do without it)"
        ) from None
    return mujoco


def joint_springs(simulation: Simulation, loads: CompositeBody) -> tuple[Floats, Floats]:
    """Compute passive stiffness and damping of the joints.

    A rule of the simulation goes first. For other joints the stiffness is k = tone m g l, with the
    mass m that the joint carries at the lever l. The damping is a share of the critical one,
    d = 2 zeta sqrt(k I).

    Returns
    -------
    tuple of Floats
        Stiffness (J,) [Nm/rad] and damping (J,) [Nm s/rad].
    """
    stiffness = simulation.tone * STANDARD_GRAVITY * loads.mass * loads.lever
    damping = 2.0 * _DAMPING_RATIO * np.sqrt(stiffness * loads.inertia)
    for rule in simulation.joints:
        for joint in rule.joints:
            if rule.stiffness is not None:
                stiffness[joint] = rule.stiffness
            if rule.damping is not None:
                damping[joint] = rule.damping
    return stiffness, damping


def model_text(simulation: Simulation, properties: MechanicalProperties) -> str:
    """Write the occupant and the belts in MJCF, the XML format of MuJoCo.

    Belt b is the tendon and the actuator `b{b}`. Body 1 of the model is the root segment.
    """
    belts = simulation.belts
    sites = _belt_sites(belts)
    tendons = [_tendon(number, belt) for number, belt in enumerate(belts)]
    actuators = [f'<motor name="b{b}" tendon="b{b}"/>' for b in range(len(belts))]
    lines = [
        f'<mujoco model="{simulation.body.name}">',
        # implicitfast: semi-implicit Euler, with the joints' damping integrated implicitly
        f'<option timestep="{simulation.step!r}" integrator="implicitfast" gravity="0 0 0">',
        '<flag contact="disable" energy="enable" autoreset="disable"/></option>',
        '<compiler angle="radian" autolimits="false" balanceinertia="true"/>',
        "<worldbody>",
        *sites.get(-1, []),
        *_subtree(simulation.body, root_segment(simulation.body), properties, sites),
        "</worldbody>",
        f"<tendon>{''.join(tendons)}</tendon><actuator>{''.join(actuators)}</actuator>",
        "</mujoco>",
    ]
    return "\n".join(lines)


def _belt_sites(belts: tuple[Belt, ...]) -> dict[int, list[str]]:
    """The belts' points by the segment to which they are fixed, -1 for the world."""
    sites: dict[int, list[str]] = {}
    for b, belt in enumerate(belts):
        for k, point in enumerate(belt.points):
            site = f'<site name="b{b}_{k}" pos="{_numbers(point.at)}"/>'
            sites.setdefault(point.segment, []).append(site)
    return sites


def _tendon(number: int, belt: Belt) -> str:
    points = "".join(f'<site site="b{number}_{k}"/>' for k in range(len(belt.points)))
    return f'<spatial name="b{number}">{points}</spatial>'


def _subtree(
    body: Body, segment: int, properties: MechanicalProperties, sites: dict[int, list[str]]
) -> list[str]:
    """A segment with all segments beyond it."""
    lines = [
        *_joint(body, segment, properties),
        _inertial(segment, properties),
        *_spheres(body, segment),
        *sites.get(segment, []),
    ]
    for child in np.flatnonzero(body.parent == segment).tolist():
        lines += _subtree(body, int(child), properties, sites)
    return [*lines, "</body>"]


def _joint(body: Body, segment: int, properties: MechanicalProperties) -> list[str]:
    """The beginning of a body element, with the joint to its parent; the root moves freely."""
    name = body.segments[segment]
    if segment == root_segment(body):
        return [f'<body name="{name}"><freejoint name="root"/>']
    joint = segment - 1
    centre = body.joint_in_child[0, joint]
    origin = body.joint_in_parent[0, joint] - centre
    stiffness = float(properties.stiffness[joint])
    damping = float(properties.damping[joint])
    return [
        f'<body name="{name}" pos="{_numbers(origin)}"><joint name="{body.joints[joint]}" type="ball" '
        f'pos="{_numbers(centre)}" stiffness="{stiffness!r}" damping="{damping!r}"/>'
    ]


def _inertial(segment: int, properties: MechanicalProperties) -> str:
    t = properties.inertia[segment]
    mass = float(properties.mass[segment])
    upper_triangle = (t[0, 0], t[1, 1], t[2, 2], t[0, 1], t[0, 2], t[1, 2])
    return f'<inertial pos="0 0 0" mass="{mass!r}" fullinertia="{_numbers(upper_triangle)}"/>'


def _spheres(body: Body, segment: int) -> list[str]:
    spheres = body.spheres(segment)
    return [
        f'<geom type="sphere" size="{float(r)!r}" pos="{_numbers(c)}" contype="0" conaffinity="0" mass="0"/>'
        for c, r in zip(body.centre[0, spheres], body.radius[0, spheres], strict=True)
    ]


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(v)) for v in values)


# Compute the moments of joint stops in a dynamic simulation.
#
# A stop is a soft, progressive spring with dissipation. Its moment grows with the angle beyond the
# stop, and it returns little of the energy that it takes.

STOP_SOFTNESS = 0.1
"""Angle [rad] beyond its stop at which a joint meets its reference moment."""
_MAX_STEEPENING = 5.0
"""Angle beyond the stop, in units of STOP_SOFTNESS, from which on the stiffness grows no more."""
_DAMPING_RATE = 15.0
"""Rate [rad/s] at which dissipation doubles an outgoing joint's moment and cancels a returning
joint's one."""


def stop_moments(pack: StopPack, rotations: Floats, rates: Floats, moment: Floats) -> Floats:
    """Compute the moments that push joints back from beyond their stops.

    Parameters
    ----------
    pack
        Joint stops of the body, see `posture.stops`.
    rotations
        (J, 4) joint rotations, unit quaternions.
    rates
        (J, 3) angular velocities [rad/s] of the distal segments, in their frames.
    moment
        (J,) reference moments [Nm], at an angle of STOP_SOFTNESS beyond the stop.

    Returns
    -------
    Floats
        (J, 3) [Nm] on the distal segments, in their frames.

    References
    ----------
    Hunt, K. H. & Crossley, F. R. E. (1975), Coefficient of restitution interpreted as damping in
    vibroimpact, Journal of Applied Mechanics 42, 440-445: damping in proportion to the elastic
    force.
    """
    joints = len(rotations)
    past = np.empty((joints, 3))  # rotation vector from the stop to the joint, zero within it
    past_stops(rotations, pack, np.empty((joints, 3)), np.empty((joints, 3, 2)), past)
    angle = np.linalg.norm(past, axis=1)
    outward_rate = np.sum(past * rates, axis=1) / np.maximum(angle, 1e-12)
    # elastic moment M(u) = M0 (u + u^3) / 2 with u = angle / STOP_SOFTNESS, here as stiffness M / angle
    u = np.minimum(angle / STOP_SOFTNESS, _MAX_STEEPENING)
    stiffness = moment * (1.0 + u**2) / (2.0 * STOP_SOFTNESS)
    # Hunt and Crossley: M (1 + rate / rate0), which neither pulls nor more than doubles
    dissipation = np.clip(1.0 + outward_rate / _DAMPING_RATE, 0.0, 2.0)
    return np.asarray(-(stiffness * dissipation)[:, None] * past)
