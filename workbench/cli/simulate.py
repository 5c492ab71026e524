"""`workbench motion simulate`: a motion file from a simulated crash."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from workbench.cli.progress import Progress, emit, tell
from workbench.errors import UsageError

if TYPE_CHECKING:
    from workbench.files.crash.simulations import SimulationPlan
    from workbench.model.simulation import Simulated

__all__ = ["simulate"]


def simulate(
    simulation: str,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])],
    forces: Path | None = None,
) -> int:
    """Simulate a crash and write its motion, for a study of kind crash to read.

    A crude simulator: rigid segments on ball joints, springs for flesh, foam and webbing, no
    muscles that answer, no injury. It shows how a body goes and what it may reach, not what it
    suffers; a test or a validated model says more. Needs MuJoCo: pip install
    'bubbleman-workbench[dynamics]'.

    Parameters
    ----------
    simulation
        a simulation file, or the name of one in studies/simulations
    out
        the motion to write: a .csv of joint angles
    forces
        also a .csv of the belts' tensions over time
    """
    from workbench.files.crash.simulations import load_simulation
    from workbench.files.motions.tables import angle_table_text
    from workbench.files.output_file import check_file, write_file
    from workbench.study.motion_cases import run_simulation

    paths = [out, forces] if forces is not None else [out]
    for path in paths:
        if path.suffix.lower() != ".csv":
            raise UsageError(f"{path}: a simulated motion and its forces are written as .csv")
        check_file(path)
    if forces is not None and forces.resolve() == out.resolve():
        raise UsageError(f"{forces}: the motion and the forces need a file each")
    with Progress() as say:
        say(f"reading {simulation}")
        plan = load_simulation(simulation)
        for path in paths:
            check_file(path)  # again, now that all inputs are known
        say(f"simulating {plan.file.duration:g} ms")
        made = run_simulation(plan)
    first, *rest = angle_table_text(plan.body, made.motion)
    about = f"# made by: the simulation {plan.file.simulation}, crude rigid-body dynamics, no measured motion\n"
    write_file(out, "".join([first, about, *rest]))
    if forces is not None:
        write_file(forces, _forces(plan, made))
    for warning in made.warnings:
        tell(f"warning: {warning}")
    emit(_summary(plan, made))
    emit(out)
    return 0


def _forces(plan: SimulationPlan, made: Simulated) -> str:
    """Tensions and payouts of the belts over time as CSV."""
    head = [
        "time [ms]",
        *(f"{b.name} {what}" for b in plan.belts for what in ("tension [N]", "payout [mm]")),
    ]
    lines = [", ".join(head)]
    for time, tension, payout in zip(made.motion.clock, made.tension, made.payout, strict=True):
        cells = [f"{v:.1f}" for pair in zip(tension, 1000 * payout, strict=True) for v in pair]
        lines.append(", ".join([f"{1000 * time:.3f}", *cells]))
    return "\n".join(lines) + "\n"


def _summary(plan: SimulationPlan, made: Simulated) -> str:
    """What came of it, in a line for the motion and one for each belt."""
    from workbench.model.simulation import gained

    clock = made.motion.clock
    speed = float(gained(plan.pulse, clock[-1:])[0])
    lines = [f"{len(clock)} frames over {1000 * clock[-1]:g} ms; the vehicle loses {speed:.2f} m/s"]
    for b, belt in enumerate(plan.belts):
        most = int(made.tension[:, b].argmax())
        lines.append(
            f"{belt.name}: up to {made.tension[most, b]:.0f} N at {1000 * clock[most]:.0f} ms, "
            f"{1000 * made.payout[most, b]:.0f} mm longer"
        )
    return "\n".join(lines)
