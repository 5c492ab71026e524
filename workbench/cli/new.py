"""`workbench new ENVIRONMENT`: a first study of an environment."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from workbench.cli.progress import emit, tell
from workbench.errors import InputError, UsageError

__all__ = ["new"]


def new(
    environment: str,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
) -> int:
    """Write a first study of an environment: somebody in each seat, contact and reach asked.

    Parameters
    ----------
    environment
        an environment's file or folder, or the name of one that comes with the workbench
    out
        the study file to write; study.yaml beside the environment where not given
    """
    from workbench.files.environments import load_environment
    from workbench.files.kinds import is_mesh
    from workbench.files.output_file import write_file
    from workbench.files.study.reader import load_study
    from workbench.study.describe.first_study import first_study

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
    if path.exists():
        raise InputError(f"{path}: is there already: name another file with -o")
    write_file(path, first_study(found, source))
    for warning in load_study(path).warnings:
        tell(f"{path}: warning: {warning}")
    emit(path)
    tell(f"next: workbench run {path}, or workbench live {path}")
    return 0
