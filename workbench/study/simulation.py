"""Simulated crashes: the occupant of a simulation file into his seat, then the dynamics."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from workbench.dynamics.crash import simulate
from workbench.files.restraints import law_in_si
from workbench.files.simulations import SimulationPlan, load_simulation
from workbench.model.environment import Environment
from workbench.model.poses import Poses
from workbench.model.simulation import Simulated, Simulation
from workbench.model.study import Person
from workbench.shape.parts import moved
from workbench.study.placement import place_person, seat_point

__all__ = ["prepared", "run_simulation"]


def run_simulation(source: str | Path | SimulationPlan) -> Simulated:
    """Simulate the crash of a file, by path or catalogue name.

    InputError for faults of the file and for a step that is too coarse; MissingPartError without MuJoCo.
    """
    plan = source if isinstance(source, SimulationPlan) else load_simulation(source)
    return simulate(prepared(plan))


def prepared(plan: SimulationPlan) -> Simulation:
    """The plan with its occupant in place."""
    file, environment, poses = plan.file, plan.environment, plan.poses
    if file.seat is not None:
        adjust = file.adjust
        person = Person("occupant", plan.body, poses, (file.posture,), seat=file.seat,
                        forward=adjust.forward if adjust else 0.0, up=adjust.up if adjust else 0.0)  # fmt: skip
        seat = environment.seat(file.seat)
        environment = moved(environment, seat.moves, seat_point(person, environment) - np.array(seat.srp))
        placed = place_person(person, environment)
        world = placed.world_from_segment[:, poses.reference]
        poses = Poses(poses.rotations, poses.reference, world)
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
        bears=_bearing(environment),
        tone=file.tone,
        gravity=file.gravity,
        duration=file.duration / 1000,
        frame=file.frames / 1000,
        step=file.step / 1000,
        settle=file.settle / 1000,
        inputs=plan.inputs,
    )


def _bearing(environment: Environment) -> np.ndarray:
    """(K,) the cushions and backs of seats."""
    names = {rest.part for seat in environment.seats for rest in (seat.cushion, seat.back)}
    return np.array([part in names for part in environment.parts], dtype=np.bool_)
