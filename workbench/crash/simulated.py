"""A crash, step by step: settle in the seat, then the pulse. Crude: rigid segments, springs for
flesh and foam.

The vehicle's frame is the world: its deceleration acts as a weight the other way. Each step of
MuJoCo's semi-implicit Euler is given the forces of stops, contacts and belts at its beginning. Same
inputs, same machine: same bytes.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from workbench.body.forward import place
from workbench.crash.contacts import Touch, contact_pushes
from workbench.crash.masses import carried, root_segment, segment_inertia, segment_masses
from workbench.crash.mjcf import engine, joint_springs, model_text
from workbench.crash.stops import packed_stops, stop_moments
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.force import force_at
from workbench.model.poses import Placed, Poses
from workbench.model.pulse import STANDARD_GRAVITY, level_at
from workbench.model.quaternions import conjugate, from_matrices, matrices, multiply
from workbench.model.simulation import Simulated, Simulation

__all__ = ["LEAST_STOP", "STOP_LOAD", "simulate"]

STOP_LOAD = 20.0
"""Under the moment of so many times the weight that it carries, a joint goes STOP_SOFTNESS past its
stop."""
LEAST_STOP = 0.04
"""[m] But for no joint is that less than the body's weight at this lever: hands are light, but
wrists are not weak."""
_HOLD = 30.0
"""How many times stiffer than in the crash joints are while the occupant settles, so that he keeps
his posture."""
_CALM = 40.0
"""[1/s] How fast speeds are taken out while the occupant settles."""
_REST = 0.004
"""[m/s] Root mean square speed at which he has settled."""
_LEAST_SETTLING = 0.1
_SETTLING_STEP = 5e-4
_SLACK_J = 25.0
"""[J] What springs of seat and flesh may hold at the start."""


def simulate(simulation: Simulation) -> Simulated:
    """Simulate a crash. MissingPartError without MuJoCo; InputError where the step is too coarse
    for the forces."""
    crash = _Crash(simulation, engine())
    left = crash.settle()
    return crash.run(left)


class _Crash:
    """The occupant under way: MuJoCo's model and data, what contacts and belts remember."""

    def __init__(self, simulation: Simulation, mujoco: ModuleType) -> None:
        self.simulation = simulation
        self.mujoco = mujoco
        body = simulation.body
        start = place(simulation.body, simulation.poses)
        mass = segment_masses(body)
        inertia = segment_inertia(body, mass)
        carries = carried(start, mass, inertia)
        text = model_text(simulation, (mass, inertia), joint_springs(simulation, carries))
        self.model: Any = mujoco.MjModel.from_xml_string(text)
        self.data: Any = mujoco.MjData(self.model)
        self.root = root_segment(body)
        self.joints = np.arange(self.root, len(body.joints))
        above = start.world_from_segment[:, max(self.root - 1, 0), :, :3]
        self.stage = conjugate(from_matrices(above))
        self.body_id = {n: n - self.root + 1 for n in range(self.root, len(body.segments))}
        self.data.qpos[:] = self._coordinates(simulation.poses, start)
        self.model.qpos_spring[:] = self.data.qpos
        self.mass = float(mass[self.root :].sum())
        self.touch = Touch.at_start(simulation, start)
        self.stops = packed_stops(body)
        weight = STANDARD_GRAVITY * np.maximum(
            STOP_LOAD * carries.mass * carries.lever, LEAST_STOP * self.mass
        )
        self.stop_moment = np.asarray(weight)
        self.belt_start = np.zeros(len(simulation.belts))
        self.belt_most = np.zeros(len(simulation.belts))
        self.belted = False
        self.held = np.zeros(self.model.nv)
        self.work = 0.0

    def _coordinates(self, poses: Poses, start: Placed) -> Floats:
        world = start.world_from_segment[0, self.root]
        turn = from_matrices(world[None, :, :3])[0]
        return np.concatenate([world[:, 3], turn, poses.rotations[0, self.joints].ravel()])

    def settle(self) -> float:
        """Let the occupant come to rest in the seat, belts undone; the speed left [m/s]."""
        most = self.simulation.settle
        least = min(_LEAST_SETTLING, self.simulation.settle)
        step = max(self.simulation.step, min(_SETTLING_STEP, 2.5 * self.simulation.step))
        self._stiffen(_HOLD)
        time = 0.0
        speed = 0.0
        self.model.opt.timestep = step
        while time < most:
            self._step(np.array([0.0, 0.0, -self.simulation.gravity]), settling=True)
            self.data.qvel[:] *= np.exp(-_CALM * step)
            time += step
            speed = float(np.sqrt(2.0 * max(self.data.energy[1], 0.0) / self.mass))
            if speed < _REST and time >= least:
                break
        self.data.qvel[:] = 0.0
        self.data.time = 0.0
        self.model.opt.timestep = self.simulation.step
        self.mujoco.mj_forward(self.model, self.data)
        # muscles go on holding what they hold: nobody answers within the time of a crash
        self.held = self.data.qfrc_passive.copy()
        self._stiffen(1.0 / _HOLD)
        self.model.qpos_spring[:] = self.data.qpos
        self.belt_start = self.data.ten_length.copy()
        self.belted = True
        return speed

    def _stiffen(self, times: float) -> None:
        """Joints that hold the posture this many times as stiff, damped in proportion."""
        held = np.isin(self.joints, self.simulation.relaxed, invert=True)
        self.model.jnt_stiffness[1:][held] *= times
        self.model.dof_damping[6:][np.repeat(held, 3)] *= np.sqrt(times)

    def run(self, left: float) -> Simulated:
        """The crash itself, a frame every `frame` [s]."""
        sim = self.simulation
        steps = max(round(sim.frame / sim.step), 1)
        frames = int(np.floor(sim.duration / (steps * sim.step) + 1e-9)) + 1
        states = np.empty((frames, len(self.data.qpos)))
        told = np.zeros((frames, 2, len(sim.belts)))
        kinetic = np.zeros(frames)
        work = np.zeros(frames)
        toward = np.array(sim.pulse.toward)
        down = np.array([0.0, 0.0, -sim.gravity])
        self.work = 0.0
        for frame in range(frames):
            states[frame] = self.data.qpos
            for step in range(steps):
                time = (frame * steps + step) * sim.step
                self._step(down + toward * float(level_at(sim.pulse, np.array([time]))[0]))
                if step == 0:
                    kinetic[frame] = self.data.energy[1]
                    work[frame] = self.work
                    told[frame] = -self.data.ctrl, self.data.ten_length - self.belt_start
                self._check(time)
        motion = self._motion(states, steps * sim.step)
        return Simulated(motion, told[:, 0], told[:, 1], kinetic, work, left, self._warnings(left))

    def _step(self, weight: Floats, *, settling: bool = False) -> None:
        """One step under a weight (3,) [m/s2]."""
        mujoco = self.mujoco
        model = self.model
        data = self.data
        model.opt.gravity[:] = weight
        mujoco.mj_step1(model, data)
        before = data.subtree_com[1].copy()
        self._load()
        mujoco.mj_step2(model, data)
        if not np.isfinite(data.qpos).all() or not np.isfinite(data.qvel).all():
            raise self._coarse(float(data.time))
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        self.work += self.mass * float(weight @ (data.subtree_com[1] - before))
        if settling and float(data.energy[1]) > 0.5 * self.mass * 9.0:
            raise self._coarse(float(data.time), settling=True)

    def _load(self) -> None:
        """Stops, contacts and belts on the model, of where it is now."""
        data = self.data
        poses = self._now()
        placed = place(self.simulation.body, poses)
        rotations = poses.rotations[0]
        rates = np.zeros((len(self.simulation.body.joints), 3))
        rates[self.joints] = data.qvel[6:].reshape(-1, 3)
        moments = stop_moments(self.stops, rotations, rates, self.stop_moment)
        data.qfrc_applied[:] = self.held
        data.qfrc_applied[6:] += moments[self.joints].ravel()
        for push in contact_pushes(self.touch, placed):
            speed = np.zeros(3)
            if push.friction > 0:
                speed = self._speed(push.segment, push.point)
            if push.friction > 0 and push.other >= 0:
                speed = speed - self._speed(push.other, push.point)
            force = push.against(speed)
            self._apply(push.segment, push.point, force)
            if push.other >= 0:
                self._apply(push.other, push.point, -force)
        if self.belted:
            for b, belt in enumerate(self.simulation.belts):
                longer = float(data.ten_length[b] - self.belt_start[b]) - belt.slack
                data.ctrl[b] = -force_at(belt.law, longer, self.belt_most[b])
                self.belt_most[b] = max(self.belt_most[b], longer)

    def _speed(self, segment: int, point: Floats) -> Floats:
        """(3,) [m/s] of a point (3,) [m] that goes with a segment."""
        moved = np.empty(6)
        body = self.body_id[segment]
        kind = self.mujoco.mjtObj.mjOBJ_XBODY
        self.mujoco.mj_objectVelocity(self.model, self.data, kind, body, moved, 0)
        (a, b, c), (x, y, z) = moved[:3].tolist(), (point - self.data.xpos[body]).tolist()
        return np.asarray(moved[3:] + np.array([b * z - c * y, c * x - a * z, a * y - b * x]))

    def _apply(self, segment: int, point: Floats, force: Floats) -> None:
        self.mujoco.mj_applyFT(
            self.model,
            self.data,
            force,
            np.zeros(3),
            point,
            self.body_id[segment],
            self.data.qfrc_applied,
        )

    def _now(self) -> Poses:
        """The pose the model is in."""
        rotations = self.simulation.poses.rotations.copy()
        turns = self.data.qpos[7:].reshape(-1, 4)
        rotations[0, self.joints] = turns / np.sqrt(np.sum(turns * turns, axis=1))[:, None]
        at = self.body_id[self.root]
        world = np.concatenate(
            [self.data.xmat[at].reshape(3, 3), self.data.xpos[at][:, None]], axis=1
        )
        return Poses(rotations, self.root, world[None])

    def _poses(self, states: Floats, time: Floats | None) -> Poses:
        rotations = np.repeat(self.simulation.poses.rotations, len(states), axis=0)
        turns = states[:, 7:].reshape(len(states), -1, 4)
        rotations[:, self.joints] = turns / np.linalg.norm(turns, axis=-1, keepdims=True)
        root = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=-1, keepdims=True)
        if self.root:  # what the root hangs from, the stage, keeps its attitude
            rotations[:, self.root - 1] = multiply(np.tile(self.stage, (len(states), 1)), root)
        world = np.concatenate([matrices(root), states[:, :3, None]], axis=-1)
        return Poses(rotations, self.root, world, time)

    def _motion(self, states: Floats, step: float) -> Poses:
        return self._poses(states, np.round(np.arange(len(states)) * step, 9))

    def _check(self, time: float) -> None:
        """What moves cannot have more energy than pulse and weight have put in."""
        kinetic = float(self.data.energy[1])
        if kinetic > 1.1 * max(self.work, 0.0) + _SLACK_J:
            raise self._coarse(time)

    def _coarse(self, time: float, *, settling: bool = False) -> InputError:
        when = "while the occupant settles" if settling else f"at {1000 * time:.1f} ms"
        step = 1000 * self.simulation.step
        return InputError(
            f"simulation {self.simulation.name}: the step of {step:g} ms is too coarse: {when} the "
            f"occupant has more energy than he was given; try 'step: {step / 4:g}'"
        )

    def _warnings(self, left: float) -> tuple[str, ...]:
        if self.simulation.settle <= 0 or left < 5 * _REST:
            return ()
        return (
            f"the occupant still moved at {1000 * left:.0f} mm/s when settling ended after "
            f"{1000 * self.simulation.settle:g} ms",
        )
