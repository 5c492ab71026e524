"""An independent judge of reaches that are said to be kept by obstacles.

It has kinematics, stops, distances and a search of its own. Of the package it takes the data of
bodies, limbs and environments, and as the last judges `place`, `contacts` and `stops`: a way counts
only where these confirm it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

import workbench as wb
from tests.judge_field import FEW, field_of
from tests.judge_limb import Chain, Skin, state_of
from tests.judge_search import MOST, POOL, Desk, Scene, search
from tests.oracles import forward
from workbench.model.joint_angles import angles_of, compose
from workbench.model.quaternions import matrices
from workbench.model.stops import StopKind
from workbench.model.surroundings import move_parts

RESTARTS = 200
CONFIRMED_TIP = 1.1e-4
"""How near [m] the tip is to the target by the package's kinematics."""
CONFIRMED_STOP = np.radians(0.1)
"""How far [rad] a joint may be past its stop by the package."""
REACH = 1.1
"""[m] How far a limb may be from the segment that it hangs on."""


@dataclass(frozen=True)
class Verdict:
    """What the judge found for one row."""

    attempt: int
    """The number of the attempt that found a way, -1 where none did."""
    angles: np.ndarray
    """(J, 3) [rad] the angles of all joints in the way, or in the best failure."""
    refused: int
    """Ways of the judge that the package did not confirm."""


def entered(body, poses, hand, *, other_arm=False):
    """(P,) [m] how deep an arm is in other segments, beyond the allowance for flesh and as far as the
    true surfaces may be inside the spheres; the fingers aside, and the other arm unless asked for."""
    found = wb.self_contacts(wb.place(body, poses))
    side = hand[0].upper()
    arm = [body.segment(side + name) for name in ("UA", "LA", "HN")]
    other = [body.segment("LR"[side == "L"] + name) for name in ("UA", "LA", "HN")]
    bends = (body.sphere_segment == arm[2]) & ~wb.limb(body, hand).solid[0]
    pair = found.segment, found.other_segment
    counts = np.isin(pair[0], arm) != np.isin(pair[1], arm)
    counts &= ~(bends[found.sphere] | bends[found.other_sphere])
    if not other_arm:
        counts &= ~(np.isin(pair[0], other) | np.isin(pair[1], other))
    error = np.nan_to_num(body.fit_error[0, :, 1])
    deep = -found.distance - body.allowance[0][pair] - error[pair[0]] - error[pair[1]]
    deepest = np.zeros(len(poses))
    np.maximum.at(deepest, found.pose[counts], deep[counts])
    return deepest


class Surroundings:
    """An environment whose parts stand still or go along with a seat."""

    def __init__(self, environment, moving_parts, bases, widest):
        """bases (n, 3) [m]: where limbs hang; widest: the largest radius [m]."""
        self.environment = environment
        self.moving_parts = tuple(moving_parts)
        corners = environment.vertices[environment.triangles]
        part = np.repeat(environment.polygon_part, np.diff(environment.triangle_start))
        shown = ~environment.hidden[part]
        moves = np.isin(np.array(environment.parts), self.moving_parts)
        low = bases.min(axis=0) - REACH
        high = bases.max(axis=0) + REACH
        self.still = self._field(corners, part, shown & ~moves[part], low, high, widest)
        self.moving = self._field(corners, part, shown & moves[part], low, high, widest)

    def _field(self, corners, part, chosen, low, high, widest):
        some = corners[chosen]
        if len(some):
            low = np.maximum(low, some.min(axis=(0, 1)) - widest)
            high = np.minimum(high, some.max(axis=(0, 1)) + widest)
        else:
            high = low
        return field_of(some, part[chosen], self.environment.solid, low, high, widest)


class Judge:
    """One limb of one person (a body of one row) in one posture, among surroundings."""

    def __init__(self, body, arm, pose, surroundings, displacement, *, heeds_body=False):
        """heeds_body: whether a way may not lead through the own body."""
        self.body = body
        self.heeds_body = heeds_body
        self.arm = arm
        self.base = forward(body, pose)[0]
        self.angles = angles_of(body, pose)[0]
        self.rotations = pose.rotations[0]
        self.surroundings = surroundings
        self.displacement = np.asarray(displacement, float)
        self.nodes = sorted(set(arm.moving) - {arm.base})
        self.node_of = {segment: k for k, segment in enumerate(self.nodes)}
        chain = self._chain()
        limits = body.stops.limits[[self.nodes[k] - 1 for k in chain.owner], chain.axis]
        self.scene = Scene(
            chain,
            self._skin(chain),
            surroundings.still,
            surroundings.moving,
            self.displacement,
            -limits[:, 1] - 1e-9,
            limits[:, 0] + 1e-9,
        )
        size = len(chain.owner)
        self.desk = Desk(
            state_of(chain),
            np.zeros(MOST),
            np.zeros((MOST, 3)),
            np.zeros(MOST, np.int64),
            np.zeros(40),
            np.zeros((40, size)),
            np.zeros((size, 3)),
            np.zeros((size, size)),
            np.zeros(size),
            np.zeros(2, np.int64),
            np.zeros((size, size)),
            np.zeros(size),
            np.zeros((2, 3)),
            np.zeros(FEW),
            np.zeros((FEW, 3)),
            np.zeros((2, 24), np.int64),
        )

    def _chain(self):
        body = self.body
        stops = body.stops
        joints = np.array(self.nodes) - 1
        free = np.isin(joints, self.arm.free)
        parent = np.array([self.node_of.get(int(body.parent[n]), -1) for n in self.nodes])
        turns = [
            (k, axis)
            for k in np.flatnonzero(free)
            for axis in range(3)
            if stops.limits[joints[k], axis].sum() > 0
        ]
        owner, axis = (np.array(column, np.int64) for column in zip(*turns, strict=True))
        turn = np.full((len(joints), 3), -1, np.int64)
        turn[owner, axis] = np.arange(len(turns))
        limits, couplings, coupled = self._limits(joints)
        shaped = [k for k in np.flatnonzero(free) if stops.kind[joints[k]] == StopKind.POLYGON]
        shaped = int(shaped[0]) if shaped else -1
        joint = joints[max(shaped, 0)]
        frame = int(stops.polygon_frame[joint])
        polygon = np.array(stops.polygon[joint]).reshape(-1, 3)
        edges = np.cross(polygon, np.roll(polygon, -1, axis=0))
        return Chain(
            parent=parent,
            held=np.ascontiguousarray(self.base[[body.parent[n] for n in self.nodes]]),
            at_parent=np.ascontiguousarray(body.joint_in_parent[0, joints]),
            at_child=np.ascontiguousarray(body.joint_in_child[0, joints]),
            axes=np.ascontiguousarray(stops.axes[joints]),
            turn=turn,
            angle=np.ascontiguousarray(self.angles[joints]),
            owner=owner,
            axis=axis,
            moves=self._moves(parent, owner),
            kind=np.where(free, stops.kind[joints], 0).astype(np.int64),
            limits=limits,
            play=np.ascontiguousarray(stops.play[joints]),
            couplings=couplings,
            coupled=coupled,
            polygon=polygon,
            edges=edges / np.linalg.norm(edges, axis=1, keepdims=True),
            wedges=np.cross(stops.polygon_centre[joint], polygon),
            window=min(8, len(polygon)),
            pointer=np.ascontiguousarray(stops.limb[joint]),
            shaped=shaped,
            frame=self.node_of.get(frame, -1),
            frame_turn=np.ascontiguousarray(self.base[frame, :, :3]),
            end=self.node_of[self.arm.end],
            tip=np.ascontiguousarray(self.arm.tip[0]),
        )

    def _moves(self, parent, owner):
        moves = np.zeros((len(parent), len(owner)), bool)
        for k, above in enumerate(parent):
            moves[k] = owner == k
            if above >= 0:
                moves[k] |= moves[above]
        return moves

    def _limits(self, joints):
        """Limits (K, 3, 2), with what is coupled to a joint that does not move at its angle; the
        couplings to those that do."""
        limits = self.body.stops.limits[joints].copy()
        rows = []
        numbers = []
        node = {int(j): k for k, j in enumerate(joints)}
        for c in self.body.stops.couplings:
            if c.joint not in node:
                continue
            k = node[c.joint]
            if c.driver_joint in node:
                rows.append((k, c.axis, c.side, node[c.driver_joint], c.driver_axis))
                numbers.append((*c.driver_angle, *c.limit))
            else:
                driver = self.angles[c.driver_joint, c.driver_axis]
                limits[k, c.axis, c.side] = np.interp(driver, c.driver_angle, c.limit)
        return (
            limits,
            np.array(rows, np.int64).reshape(-1, 5),
            np.array(numbers, float).reshape(-1, 4),
        )

    def _skin(self, chain):
        body = self.body
        sphere = np.flatnonzero(self.arm.solid[0])
        segment = body.sphere_segment[sphere]
        twist_joint = body.twist_joint[segment]
        line = body.twist_axis[0, segment]
        along = np.einsum("si,si->s", line, body.stops.axes[np.maximum(twist_joint, 0), 2])
        share = np.where(twist_joint >= 0, body.twist_share[0, sphere], 0.0)
        share = share * np.where(along < 0, -1.0, 1.0)
        blend_joint = np.where(body.blend_share[0, sphere] > 0, body.blend_joint[sphere], -1)
        distal = blend_joint == segment - 1
        at = np.maximum(blend_joint, 0)
        point = np.where(distal[:, None], body.joint_in_child[0, at], body.joint_in_parent[0, at])
        sharing = set(body.twist_joint[body.twist_joint >= 0].tolist())
        allowed = np.zeros((len(body.segments), len(self.surroundings.environment.parts)))
        for rule in self.surroundings.environment.allowances:
            for n, name in enumerate(body.segments):
                if name in rule.segments or "all" in rule.segments:
                    allowed[n, rule.part] = max(allowed[n, rule.part], rule.depth)
        skin = Skin(
            segment=np.array([self.node_of[n] for n in segment], np.int64),
            centre=np.ascontiguousarray(body.centre[0, sphere]),
            radius=np.ascontiguousarray(body.radius[0, sphere]),
            allowed=np.ascontiguousarray(allowed[segment]),
            twist=np.where(share != 0, self._nodes_of(twist_joint), -1),
            twist_share=share,
            twist_point=np.ascontiguousarray(body.twist_point[0, segment]),
            twist_axis=np.ascontiguousarray(line),
            blend=self._nodes_of(blend_joint),
            blend_share=np.ascontiguousarray(body.blend_share[0, sphere]),
            blend_point=np.ascontiguousarray(point),
            distal=distal,
            shared=np.array([j in sharing for j in blend_joint]),
        )
        self._settle(skin, twist_joint, blend_joint)
        return skin

    def _nodes_of(self, joints):
        """(S,) the moving segments whose joints these are, -1 where there is none."""
        return np.array([self.node_of.get(int(j) + 1, -1) for j in joints], np.int64)

    def _settle(self, skin, twist_joint, blend_joint):
        """Move centres by what joints that do not move share with them."""
        for s in range(len(skin.radius)):
            centre = skin.centre[s]
            if skin.twist[s] < 0 and skin.twist_share[s] != 0:
                angle = skin.twist_share[s] * self.angles[twist_joint[s], 2]
                axis = skin.twist_axis[s]
                v = centre - skin.twist_point[s]
                centre[:] = (
                    skin.twist_point[s]
                    + np.cos(angle) * v
                    + np.sin(angle) * np.cross(axis, v)
                    + (1 - np.cos(angle)) * (axis @ v) * axis
                )
            if skin.blend[s] < 0 and blend_joint[s] >= 0:
                # a proximal sphere of a joint that hangs on the limb but is no part of it
                assert not skin.distal[s]
                turn = self.rotations[blend_joint[s]]
                if skin.shared[s]:
                    angles = np.zeros((len(self.body.joints), 3))
                    angles[:, :2] = self.angles[:, :2]
                    turn = compose(self.body, angles)[blend_joint[s]]
                v = centre - skin.blend_point[s]
                centre[:] += skin.blend_share[s] * (matrices(turn[None])[0] @ v - v)

    @cached_property
    def room(self):
        """The environment as it stands for this person."""
        return move_parts(
            self.surroundings.environment, self.surroundings.moving_parts, self.displacement
        )

    def angles_at(self, turns):
        """(J, 3) the angles of all joints at turns (D,)."""
        angles = self.angles.copy()
        chain = self.scene.chain
        joints = np.array(self.nodes)[chain.owner] - 1
        angles[joints, chain.axis] = turns
        return angles

    def posed(self, angles):
        """The poses with the joints of the limb at angles (P, J, 3) or (J, 3), held by the limb's
        base."""
        angles = angles.reshape(-1, *self.angles.shape)
        rotations = np.repeat(self.rotations[None], len(angles), axis=0)
        free = list(self.arm.free)
        rotations[:, free] = compose(self.body, angles)[:, free]
        base = np.repeat(self.base[None, self.arm.base], len(angles), axis=0)
        return wb.Poses(rotations, self.arm.base, base)

    def confirms(self, angles, target):
        """Whether place, contacts and stops of the package agree that angles (J, 3) are a way."""
        pose = self.posed(angles)
        placed = wb.place(self.body, pose)
        end = placed.world_from_segment[0, self.arm.end]
        tip = end[:, :3] @ self.arm.tip[0] + end[:, 3]
        if np.linalg.norm(tip - target) > CONFIRMED_TIP:
            return False
        margin = wb.stops(self.body, pose).margin[0, list(self.arm.free)]
        if margin.min() < -CONFIRMED_STOP:
            return False
        if self.heeds_body and entered(self.body, pose, self.arm.name.split(",")[0])[0] > 0.0:
            return False
        met = wb.contacts(placed, self.room)
        return not np.any(self.arm.solid[0, met.sphere] & (met.excess > 0))

    def judge(self, target, *, restarts=RESTARTS, seed=1):
        """Search a way to a target (3,) by random restarts."""
        target = np.asarray(target, float)
        size = len(self.scene.chain.owner)
        pool = np.zeros((POOL, size))
        sums = np.full(POOL, np.inf)
        turns = np.zeros(size)
        first = 0
        refused = 0
        while first < restarts:
            found = search(self.scene, target, seed, first, restarts, self.desk, pool, sums, turns)
            angles = self.angles_at(turns)
            if found < 0:
                break
            if self.confirms(angles, target):
                return Verdict(found, angles, refused)
            refused += 1
            first = found + 1
        return Verdict(-1, self.angles_at(pool[0]), refused)


__all__ = ["RESTARTS", "Judge", "Surroundings", "Verdict", "entered"]
