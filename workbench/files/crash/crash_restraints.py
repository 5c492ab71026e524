"""What holds the occupant of a crash study's motion: stated in the study, or by the simulation that
made the motion."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from workbench.errors import InputError
from workbench.files.crash.restraints import belt_faults, belts_of, pulse_of
from workbench.files.crash.schema import CrashFile
from workbench.files.crash.simulation_schema import AirbagFile
from workbench.files.crash.simulations import SimulationPlan, load_simulation
from workbench.files.schema import fail
from workbench.files.yaml_text import Document
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.pulse import Pulse
from workbench.model.simulation import Belt

__all__ = ["Restraints", "restraints_of"]


@dataclass(frozen=True, eq=False)
class Restraints:
    """Belts and airbags that become parts, and the vehicle's pulse; simulation: where they come
    from, if they do."""

    pulse: Pulse | None = None
    belts: tuple[Belt, ...] = ()
    airbags: tuple[AirbagFile, ...] = ()
    simulation: SimulationPlan | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The parts they become: airbags, then belts."""
        return (*(bag.name for bag in self.airbags), *(belt.name for belt in self.belts))


Work = tuple[Environment, Body, dict[str, Path]]


def restraints_of(
    document: Document, file: CrashFile, key: str, work: Work
) -> tuple[Restraints, list[str]]:
    """The restraints of `motion` or `against`, and what is wrong with them; files they are made of
    go to the inputs."""
    source = file.motion if key == "motion" else file.against
    if source is None:
        return Restraints(), []
    if source.simulation is None:
        return _stated(document, file, work)
    environment, body, inputs = work
    try:
        plan = load_simulation(source.simulation, near=Path(document.file).parent)
    except InputError as error:
        return Restraints(), [
            fail(document, (key, "simulation"), problem) for problem in error.problems
        ]
    wrong = [
        f"it is in {what} {theirs!r}, this study in {ours!r}"
        for what, theirs, ours in (
            ("environment", plan.environment.name, environment.name),
            ("body", plan.body.name, body.name),
        )
        if theirs != ours
    ]
    inputs |= {
        f"simulation of {key}" if name == "simulation" else name: path
        for name, path in plan.inputs.items()
        if name in ("simulation", "pulse")
    }
    found = Restraints(plan.pulse, plan.belts, tuple(plan.file.airbags), plan)
    return found, [fail(document, (key, "simulation"), what) for what in wrong]


def _stated(document: Document, file: CrashFile, work: Work) -> tuple[Restraints, list[str]]:
    environment, body, inputs = work
    folder = Path(document.file).parent
    anchors = {**environment.points, **file.anchors}
    faults = []
    seen = set(environment.parts)
    for row, bag in enumerate(file.airbags):
        if bag.name in seen:
            faults.append(
                fail(document, ("airbags", row, "name"), f"a part is named {bag.name!r} already")
            )
        seen.add(bag.name)
    faults += belt_faults(document, file.belts, (body, anchors, seen))
    pulse = None
    if file.pulse is not None:
        inputs |= {"pulse": folder / file.pulse.file} if file.pulse.file is not None else {}
        try:
            pulse = pulse_of(file.pulse, folder)
        except InputError as error:
            faults += [fail(document, ("pulse",), problem) for problem in error.problems]
    if faults:
        return Restraints(), faults
    return Restraints(pulse, belts_of(file.belts, body, anchors), tuple(file.airbags)), []
