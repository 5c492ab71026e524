"""A sphere body as a MuJoCo model: a tree of rigid bodies on ball joints, spheres as geoms, belts
as spatial tendons.

MuJoCo (Todorov, Erez & Tassa 2012) does the dynamics of the tree and the geometry of the tendons.
Contacts and stops are forces of this room: a stiffness in newtons a millimetre cannot be told to
its soft constraints, whose stiffness goes with the mass, nor can concave parts be told to its
convex geoms. So the geoms only show where the spheres are.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from workbench.crash.masses import Carried, root_segment
from workbench.errors import MissingPartError
from workbench.model.arrays import Floats
from workbench.model.pulse import STANDARD_GRAVITY
from workbench.model.simulation import Simulation

__all__ = ["engine", "joint_springs", "model_text"]

_DAMPED = 0.3
"""Of critical damping, on the stiffness and inertia of each joint."""


def engine() -> ModuleType:
    """MuJoCo; MissingPartError where it is not installed."""
    try:
        import mujoco
    except ImportError:
        raise MissingPartError(
            "simulated crashes need MuJoCo: pip install 'bubbleman-workbench[dynamics]' (stored motions do without it)"
        ) from None
    return mujoco  # type: ignore[no-any-return]


def joint_springs(simulation: Simulation, carries: Carried) -> tuple[Floats, Floats]:
    """(J,) stiffness [Nm/rad] and damping [Nm s/rad]: `tone` times the moment of the weight that
    the joint carries, and 0.3 of the critical damping with it; the simulation's rules where they
    say otherwise."""
    stiffness = simulation.tone * STANDARD_GRAVITY * carries.mass * carries.lever
    damping = 2.0 * _DAMPED * np.sqrt(stiffness * carries.inertia)
    for rule in simulation.joints:
        for j in rule.joints:
            stiffness[j] = stiffness[j] if rule.stiffness is None else rule.stiffness
            damping[j] = damping[j] if rule.damping is None else rule.damping
    return stiffness, damping


def model_text(
    simulation: Simulation, parts: tuple[Floats, Floats], springs: tuple[Floats, Floats]
) -> str:
    """MJCF of the occupant and the belts; parts: masses (N,) and inertias (N, 3, 3), springs: those
    of the joints."""
    body = simulation.body
    root = root_segment(simulation.body)
    sites: dict[int, list[str]] = {}
    for b, belt in enumerate(simulation.belts):
        for k, point in enumerate(belt.points):
            sites.setdefault(point.segment, []).append(
                f'<site name="b{b}_{k}" pos="{_row(point.at)}"/>'
            )
    tendons = [
        f'<spatial name="b{b}">'
        + "".join(f'<site site="b{b}_{k}"/>' for k in range(len(belt.points)))
        + "</spatial>"
        for b, belt in enumerate(simulation.belts)
    ]
    motors = [f'<motor name="b{b}" tendon="b{b}"/>' for b in range(len(simulation.belts))]
    lines = [
        f'<mujoco model="{body.name}">',
        f'<option timestep="{simulation.step!r}" integrator="implicitfast" gravity="0 0 0">',
        '<flag contact="disable" energy="enable" autoreset="disable"/></option>',
        '<compiler angle="radian" autolimits="false" balanceinertia="true"/>',
        "<worldbody>",
        *sites.get(-1, []),
        *_segment(simulation, root, (parts, springs, sites)),
        "</worldbody>",
        f"<tendon>{''.join(tendons)}</tendon><actuator>{''.join(motors)}</actuator>",
        "</mujoco>",
    ]
    return "\n".join(lines)


def _segment(simulation: Simulation, n: int, given: Any) -> list[str]:
    """A segment with all beyond it."""
    (mass, inertia), (stiffness, damping), sites = given
    body = simulation.body
    j = n - 1
    name = simulation.body.segments[n]
    if n == root_segment(body):
        lines = [f'<body name="{name}"><freejoint name="root"/>']
    else:
        place = body.joint_in_parent[0, j] - body.joint_in_child[0, j]
        passive = f'stiffness="{float(stiffness[j])!r}" damping="{float(damping[j])!r}"'
        lines = [
            f'<body name="{name}" pos="{_row(place)}"><joint name="{body.joints[j]}" type="ball" '
            f'pos="{_row(body.joint_in_child[0, j])}" {passive}/>'
        ]
    t = inertia[n]
    full = (t[0, 0], t[1, 1], t[2, 2], t[0, 1], t[0, 2], t[1, 2])
    lines.append(f'<inertial pos="0 0 0" mass="{float(mass[n])!r}" fullinertia="{_row(full)}"/>')
    some = body.spheres(n)
    lines += [
        f'<geom type="sphere" size="{float(r)!r}" pos="{_row(c)}" contype="0" conaffinity="0" mass="0"/>'
        for c, r in zip(body.centre[0, some], body.radius[0, some], strict=True)
    ]
    lines += sites.get(n, [])
    for child in np.flatnonzero(body.parent == n).tolist():
        lines += _segment(simulation, int(child), given)
    return [*lines, "</body>"]


def _row(values: Any) -> str:
    return " ".join(repr(float(v)) for v in values)
