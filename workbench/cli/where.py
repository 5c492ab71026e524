"""`workbench where STUDY --control NAME`: where a control may be so that enough people reach it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from workbench.cli.progress import Progress, emit, emit_sentence, tell

__all__ = ["where"]


def where(
    study: str,
    *,
    control: str,
    share: float = 95.0,
    within: float | None = None,
    spacing: float | None = None,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
) -> int:
    """Find the places about a control's own at which a share of a population reaches it: a table, a
    picture, and the nearest such place. Obstacles are heeded.

    Exit code 0 where there is such a place, 1 where there is none.

    Parameters
    ----------
    study
        a study file of a population, or the name of one that comes with the workbench
    control
        the control of its environment
    share
        percent of the people who are to reach it
    within
        how far from its place others are looked at [mm], 300 where not given; twice as far while no
        place is found
    spacing
        how far these are apart [mm], 40 where not given
    out
        the folder to write; out/where_<control> where not given
    """
    from workbench.files.output_folder import check_folder
    from workbench.files.study.reader import load_study
    from workbench.report.control_region import write_region
    from workbench.study.accommodation.control_regions import (
        SPACING,
        WITHIN,
        check_region,
        control_region,
    )
    from workbench.study.people import present_people

    kept: list[str] = []
    reach = WITHIN if within is None else within / 1000
    step = SPACING if spacing is None else spacing / 1000
    with Progress() as say:
        if out is not None:
            check_folder(out, holds="region")  # before the work, not after it
        say(f"reading {study}")
        loaded = load_study(study)
        check_region(loaded, control, share=share / 100, within=reach, spacing=step)
        folder = out or Path("out") / f"where_{control}"
        check_folder(folder, holds="region")  # again, now that all inputs are known
        found = control_region(
            loaded,
            control,
            share=share / 100,
            within=reach,
            spacing=step,
            beside=present_people(loaded) if len(loaded.roles) > 1 else None,
            say=say,
        )
        say("writing")
        lines = write_region(found, folder, tell=kept.append)
    for line in kept:
        tell(f"warning: {line}")
    for line in lines:
        emit_sentence(line)
    emit(folder / "region.svg")
    return 0 if found.enough.any() else 1
