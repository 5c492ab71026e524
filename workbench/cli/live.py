"""`workbench live STUDY`: a study in the browser, answered while it is changed."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from workbench.cli.progress import Progress, emit, tell
from workbench.errors import InputError, UsageError

if TYPE_CHECKING:
    from workbench.report.running import Written

__all__ = ["live"]


def _run_and_write(source: str, *, say: Callable[[str], None]) -> Written:
    """Run a study as `workbench run` does; what that needs is loaded in the process that does it."""
    from workbench.report.running import run_and_write

    return run_and_write(source, say=say)


def live(
    study: str,
    *more: str,
    port: int = 0,
    browser: Annotated[bool, Parameter(negative="--no-browser")] = True,
    read_only: Annotated[bool, Parameter(negative="")] = False,
    size: str = "",
    out: str = "",
) -> int:
    """Open a study in the browser: turn joints, bring hands to controls, move seats, and see at
    once what comes near to what and which criteria hold. Or open a mesh, and make an environment of
    it by pointing.

    It is served to this machine alone, until Ctrl-C. From another machine use ssh -L.

    Parameters
    ----------
    study
        a study file, or the name of one that comes with the workbench, which is not written over;
        or a mesh file, or an environment's file or folder, which is described by pointing
    more
        more mesh files of the same environment
    port
        the port to serve at; a free one where not given
    browser
        open the address in the browser
    read_only
        save nothing
    size
        of a role that several sizes take one at a time, the one that is shown
    out
        the file or folder in which an environment is saved; beside its mesh where not given
    """
    if not 0 <= port <= 65535:
        raise UsageError(f"--port: a number from 0 to 65535 is needed, got {port}")
    from workbench.files.catalogue import names
    from workbench.files.kinds import is_environment
    from workbench.live.describe_desk import DescribeDesk
    from workbench.live.desk import Desk
    from workbench.live.server import serve

    if Path(study).is_dir() and study not in names("studies") and not is_environment(study):
        raise InputError(f"{study}: holds no environment.yaml: name the mesh in it")
    desk: Desk | DescribeDesk
    with Progress() as say:
        say(f"reading {study}")
        if is_environment(study):
            if size:
                raise UsageError("--size: an environment has no people")
            desk = DescribeDesk(study, *more, out=out, read_only=read_only)
        else:
            if more:
                raise UsageError(
                    f"{more[0]}: a study is opened alone; several are possible of meshes"
                )
            if out:
                raise UsageError("--out: a study is saved in its own file")
            desk = Desk(study, size=size, read_only=read_only)

    def ready(address: str) -> None:
        emit(address)
        tell("The bench is served to this machine alone, until Ctrl-C.")
        if browser:
            webbrowser.open(address)

    def ended(words: str) -> None:
        if words:
            tell(words)

    serve(desk, port=port, ready=ready, runner=_run_and_write, ended=ended)
    return 0
