"""Simulated crashes: the occupant of a simulation file into his seat, then the dynamics."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from workbench.crash.simulated import simulate
from workbench.files.crash.restraints import law_in_si
from workbench.files.crash.simulations import SimulationPlan, load_simulation
from workbench.model.arrays import Bools
from workbench.model.environment import Environment
from workbench.model.simulation import Simulated, Simulation
from workbench.posture.seating.seat import seat
from workbench.posture.seating.seating import seat_at

__all__ = ["bearing", "prepared", "run_simulation"]


def run_simulation(source: str | Path | SimulationPlan) -> Simulated:
    """Simulate the crash of a file, by path or catalogue name.

    InputError for faults of the file and for a step that is too coarse; MissingPartError without
    MuJoCo.
    """
    plan = source if isinstance(source, SimulationPlan) else load_simulation(source)
    return simulate(prepared(plan))


def prepared(plan: SimulationPlan) -> Simulation:
    """The plan with its occupant in the seat, and the seat where the occupant has put it."""
    file = plan.file
    poses = plan.poses
    environment = plan.environment
    if file.seat is not None:
        at = file.adjust
        forward, up = (at.forward, at.up) if at is not None else (0.0, 0.0)
        held = environment.seat(file.seat).held(forward, up)
        poses = seat(plan.body, poses, held).poses
        environment = seat_at(environment, file.seat, forward, up)
    return Simulation(
        name=file.simulation,
        body=plan.body,
        environment=environment,
        poses=poses,
        pulse=plan.pulse,
        belts=plan.belts,
        rules=plan.rules,
        other=law_in_si(file.others),
        flesh=law_in_si(file.flesh),
        joints=plan.joints,
        relaxed=tuple(plan.body.joint(name) for name in file.relaxed),
        bears=bearing(environment, [bag.name for bag in file.airbags]),
        tone=file.tone,
        gravity=file.gravity,
        duration=file.duration / 1000,
        frame=file.frames / 1000,
        step=file.step / 1000,
        settle=file.settle / 1000,
        inputs=plan.inputs,
    )


def bearing(environment: Environment, more: Iterable[str] = ()) -> Bools:
    """(K,) the cushions and backs of seats, and the parts named: what pushes back from its surface
    on."""
    names = {part for seat in environment.seats for part in seat.parts} | set(more)
    return np.array([part in names for part in environment.parts], dtype=np.bool_)
