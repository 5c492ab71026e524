"""Simulated crashes: the occupant of a simulation file into his seat, then the dynamics."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from workbench.body.parts import moved
from workbench.crash.simulated import simulate
from workbench.files.crash.restraints import law_in_si
from workbench.files.crash.simulations import SimulationPlan, load_simulation
from workbench.model.arrays import Bools
from workbench.model.environment import Environment
from workbench.model.poses import Poses
from workbench.model.posture_study import Person
from workbench.model.simulation import Simulated, Simulation
from workbench.study.placement import place_person, seat_point

__all__ = ["bearing", "prepared", "run_simulation"]


def run_simulation(source: str | Path | SimulationPlan) -> Simulated:
    """Simulate the crash of a file, by path or catalogue name.

    InputError for faults of the file and for a step that is too coarse; MissingPartError without
    MuJoCo.
    """
    plan = source if isinstance(source, SimulationPlan) else load_simulation(source)
    return simulate(prepared(plan))


def prepared(plan: SimulationPlan) -> Simulation:
    """The plan with its occupant in place."""
    file = plan.file
    poses = plan.poses
    environment = _seated_environment(plan, plan.environment)
    if file.seat is not None:
        placed = place_person(_sitter(plan), environment)
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
        bears=bearing(environment, [bag.name for bag in file.airbags]),
        tone=file.tone,
        gravity=file.gravity,
        duration=file.duration / 1000,
        frame=file.frames / 1000,
        step=file.step / 1000,
        settle=file.settle / 1000,
        inputs=plan.inputs,
    )


def _seated_environment(plan: SimulationPlan, environment: Environment) -> Environment:
    """An environment with the simulation's seat where its sitter has put it."""
    adjust = plan.file.adjust
    name = plan.file.seat
    if adjust is None or name is None:
        return environment
    seat = environment.seat(name)
    return moved(
        environment, seat.moves, seat_point(_sitter(plan), environment) - np.array(seat.srp)
    )


def _sitter(plan: SimulationPlan) -> Person:
    adjust = plan.file.adjust
    return Person(
        "occupant",
        plan.body,
        plan.poses,
        (plan.file.posture,),
        seat=plan.file.seat,
        forward=adjust.forward if adjust else 0.0,
        up=adjust.up if adjust else 0.0,
    )


def bearing(environment: Environment, more: Iterable[str] = ()) -> Bools:
    """(K,) the cushions and backs of seats, and the parts named: what pushes back from its surface
    on."""
    names = {rest.part for seat in environment.seats for rest in (seat.cushion, seat.back)} | set(
        more
    )
    return np.array([part in names for part in environment.parts], dtype=np.bool_)
