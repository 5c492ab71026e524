"""`workbench new ENVIRONMENT`: a first study of an environment."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter, validators

from workbench.cli.progress import emit, emit_sentence, tell
from workbench.errors import InputError, UsageError

__all__ = ["new"]


def new(
    environment: str,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    people: Annotated[int, Parameter(validator=validators.Number(gte=0))] = 0,
) -> int:
    """Write a first study of an environment: somebody in each seat or at the controls, with what a
    reviewer asks. It says what was guessed, and by what.

    Parameters
    ----------
    environment
        an environment's file or folder, or the name of one that comes with the workbench
    out
        the study file to write; study.yaml beside the environment where not given
    people
        write the study of so many people of a survey too, in STUDY_people.yaml beside it; a STUDY
        that is there already stays as it is
    """
    from workbench.files.kinds import is_mesh
    from workbench.study.describe.saving import people_study, save_first_study

    if is_mesh(environment):
        raise UsageError(
            f"{environment} is a mesh: make an environment of it first, workbench live {environment}"
        )
    given = Path(environment)
    source = given / "environment.yaml" if given.is_dir() else given
    path = out or (source.parent if given.exists() else Path()) / "study.yaml"
    wanted = {path: 0}
    if people:
        wanted[people_study(path)] = people
    missing = {each: many for each, many in wanted.items() if not each.exists()}
    *first, last = wanted
    if last not in missing:
        raise InputError(f"{last}: is there already: name another file with -o")
    for each in [one for one in first if one not in missing]:
        tell(f"{each}: is there already and stays as it is")
    told: set[str] = set()
    for each, many in missing.items():
        made = save_first_study(source if given.exists() else environment, each, people=many)
        for line in [one for one in made.guesses if one not in told]:
            emit_sentence(f"guessed: {line}")
        for warning in [one for one in made.warnings if one not in told]:
            tell(f"{each}: warning: {warning}")
        told |= {*made.guesses, *made.warnings}
    for each in missing:
        emit(each)
        tell(f"next: workbench run {each}, or workbench live {each}")
    return 0
