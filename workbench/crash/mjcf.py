"""Write a sphere body and its belts as a MuJoCo model [1]_.

Segments are a tree of rigid bodies on ball joints, belts are spatial tendons. MuJoCo computes the
dynamics of the tree and the geometry of the tendons. Contacts and joint stops are applied forces:
the stiffness of MuJoCo's soft constraints scales with the mass, so a stiffness in N/mm cannot be
given to them, and its collision detection needs convex parts. Spheres are geoms for display only.

References
----------
.. [1] E. Todorov, T. Erez & Y. Tassa (2012), MuJoCo: A physics engine for model-based control,
   IEEE/RSJ International Conference on Intelligent Robots and Systems, 5026-5033.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from workbench.crash.masses import CompositeBody, root_segment
from workbench.errors import MissingPartError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.pulse import STANDARD_GRAVITY
from workbench.model.simulation import Belt, Simulation

__all__ = ["MechanicalProperties", "import_mujoco", "joint_springs", "model_text"]

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
    return mujoco  # type: ignore[no-any-return]


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
