"""`workbench new ENVIRONMENT`: a first study of an environment."""

from __future__ import annotations

import os
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
        write the study of so many people of a survey too, in STUDY_people.yaml beside it
    """
    from workbench.files.environments import load_environment
    from workbench.files.kinds import is_mesh
    from workbench.files.output_file import write_file
    from workbench.files.study.reader import load_study
    from workbench.study.describe.first_study import first_study, guesses_of

    if is_mesh(environment):
        raise UsageError(
            f"{environment} is a mesh: make an environment of it first, workbench live {environment}"
        )
    given = Path(environment)
    found = load_environment(environment)
    if not given.exists():
        source = environment
        path = out or Path("study.yaml")
    else:
        inner = given / "environment.yaml" if given.is_dir() else given
        path = out or inner.parent / "study.yaml"
        source = Path(os.path.relpath(inner.resolve(), path.resolve().parent)).as_posix()
    wanted = {path: 0}
    if people:
        wanted[path.with_stem(f"{path.stem}_people")] = people
    for each in wanted:
        if each.exists():
            raise InputError(f"{each}: is there already: name another file with -o")
    for each, many in wanted.items():
        text = first_study(found, source, people=many)
        write_file(each, text)
        if not many:
            for line in guesses_of(text):
                emit_sentence(f"guessed: {line}")
    for warning in load_study(path).warnings:
        tell(f"{path}: warning: {warning}")
    for each in wanted:
        emit(each)
        tell(f"next: workbench run {each}, or workbench live {each}")
    return 0
