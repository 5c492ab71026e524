"""The command `workbench`: the only place that prints. Data goes to stdout, talk to stderr.

Exit codes: 0 fine, 1 ran and a criterion failed, 2 usage, 3 bad input, 4 an optional part is
missing, 70 an internal error, 130 stopped by Ctrl-C.
"""

from __future__ import annotations

import io
import json
import os
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, CycloptsError, Parameter

from workbench import __version__
from workbench.cli.body import body_app
from workbench.cli.compare import compare
from workbench.cli.interrupts import heard
from workbench.cli.live import live
from workbench.cli.motion import motion_app
from workbench.cli.new import new
from workbench.cli.people import people_app
from workbench.cli.progress import Progress, emit, emit_sentence, emit_verdict, tell
from workbench.cli.render import render
from workbench.cli.where import where
from workbench.errors import InputError, UsageError, WorkbenchError, one_of
from workbench.files.file_errors import noted_inputs

if TYPE_CHECKING:
    from workbench.files.mesh_report import Inspection
    from workbench.files.results.result import ResultFile
    from workbench.study.describe.named_seat import NamedSeat


__all__ = ["app", "main"]

INTERNAL_ERROR = 70
"""Exit code of an error that the program did not expect, EX_SOFTWARE of sysexits.h."""
INTERRUPTED = 130

app = App(
    name="workbench",
    version=__version__,
    version_flags=["--version", "-V"],
    help="Human factors with sphere bodies: reach, clearance and collision studies from files.",
    help_epilogue="Exit codes: 0 fine, 1 a criterion failed, 2 usage, 3 bad input, 4 an optional part is missing, "
    "70 an internal error, 130 stopped by Ctrl-C.",
    suppress_keyboard_interrupt=False,
)
app.command(body_app)
app.command(people_app)
app.command(motion_app)
app.command(render)
app.command(compare)
app.command(live)
app.command(new)
app.command(where)
app.register_install_completion_command(help="Complete commands and options in this shell.")

Json = Annotated[bool, Parameter(name="--json", negative="", help="print data as JSON on stdout")]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command line; returns the exit code."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        # a terminal that cannot show a letter shows its number
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        with noted_inputs():
            code = app(
                list(sys.argv[1:] if arguments is None else arguments),
                exit_on_error=False,
                print_error=False,
                result_action="return_value",
            )
        sys.stdout.flush()
    except CycloptsError as error:
        tell(f"workbench: {error}".rstrip() + "\nworkbench --help lists the commands.")
        return 2
    except WorkbenchError as error:
        tell(str(error))
        return error.exit_code
    except BrokenPipeError:
        # the reader has seen enough; what is left to print must not fail again at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        tell(f"{where}cannot read or write: {error.strerror}")
        return 3
    except KeyboardInterrupt as error:
        tell(str(error) or "stopped")
        return INTERRUPTED
    except Exception as error:  # noqa: BLE001 (the one place for errors that nobody expects)
        return _unexpected(error)
    return code if isinstance(code, int) else 0


def _unexpected(error: Exception) -> int:
    """Report an error that the program did not raise on purpose; returns the exit code."""
    if heard() or _was_interrupted(error):
        tell("stopped")
        return INTERRUPTED
    if os.environ.get("WORKBENCH_TRACEBACK", "") not in ("", "0"):
        tell("".join(traceback.format_exception(error)).rstrip())
    said = " ".join(str(error).split())
    if isinstance(error, MemoryError):
        why = f" ({said})" if said else ""
        tell(f"out of memory{why}: give fewer people, frames, points or pixels, or a simpler mesh")
        return WorkbenchError.exit_code
    if isinstance(error, RecursionError):
        what = "an input is nested too deeply, or the workbench calls itself without end"
    else:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        what = f"{type(error).__name__} in {Path(frame.filename).name}, line {frame.lineno}: {said or 'no reason'}"
    tell(f"internal error: {what}")
    tell(
        "Please report this with the command and its files. WORKBENCH_TRACEBACK=1 shows where it happened."
    )
    return INTERNAL_ERROR


def _was_interrupted(error: BaseException | None) -> bool:
    """Whether an error came of Ctrl-C: an import that is interrupted may raise another one
    instead."""
    seen = set()
    while error is not None and id(error) not in seen:
        if isinstance(error, KeyboardInterrupt):
            return True
        seen.add(id(error))
        error = error.__cause__ or error.__context__
    return False


@app.command
def run(
    study: str,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    film: bool = False,
    cluster: str | None = None,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative="")] = False,
    as_json: Json = False,
) -> int:
    """Run a study and write its report.

    Parameters
    ----------
    study
        a study file, or the name of one that comes with the workbench
    out
        the folder to write; out/<study> where not given
    film
        a film with the report of a motion
    cluster
        of a population: a Dask scheduler's address that does the work (tcp://host:8786), or local
    quiet
        print nothing but warnings and errors: the exit code says whether all criteria hold
    """
    with Progress() as say:
        say(f"reading {study}")  # before the imports, which take a second
        from workbench.report.running import run_and_write

        done = run_and_write(study, out, film=film, cluster=cluster, say=say)
    for warning in done.warnings:
        tell(f"warning: {warning}")
    if as_json:
        emit(_dumped(done.rows))
    elif not quiet:
        for line in done.lines:
            emit_verdict(line)
        emit_sentence(done.rows.headline)
        emit(done.folder / "report.html")
    return 0 if done.passed else 1


@app.command
def check(*files: Path) -> int:
    """Check study, body, environment and posture files without running anything.

    Parameters
    ----------
    files
        the files to check
    """
    from workbench.files.kinds import check_file
    from workbench.study.accommodation.limiting_dimensions import doubted_people

    if not files:
        raise UsageError("workbench check: name one file or more")
    faults: list[str] = []
    for path in files:
        try:
            found = check_file(path)
            who = () if found.study is None else doubted_people(found.study)
            warnings = (*found.warnings, *who)
            for warning in warnings:
                tell(f"{path}: warning: {warning}")
            for words in found.assumed:
                tell(f"{path}: assumed: {words}")
        except InputError as error:
            faults += error.problems
        else:
            count = len(warnings)
            emit(f"{path}: ok" + (f", {count} warning{'s' * (count > 1)}" if count else ""))
    if faults:
        raise InputError(faults)
    return 0


@app.command
def inspect(
    *sources: str,
    units: str | None = None,
    up: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    forward: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    seat: tuple[str, str] | None = None,
    as_json: Json = False,
) -> int:
    """Show the parts, sizes, quality and warnings of mesh files or an environment, or what a result
    says.

    Parameters
    ----------
    sources
        a mesh file, an environment folder or its name, or a folder with a result; several mesh
        files that stand in one frame, each with a move where it needs one
        (wheel.stl@400mm,0,250mm: so much forward, left and up)
    units
        the unit of length of a mesh file: mm, cm, m, in or ft
    up
        the mesh's upward axis, such as z or -y
    forward
        the mesh's forward axis; what is neither given nor said by the file is assumed, and told
    seat
        the parts of a seat's cushion and of its back: its reference point and angles are computed,
        printed as lines of an environment's file, and checked
    """
    from workbench.files.kinds import is_mesh, is_result
    from workbench.files.mesh_report import inspect_environment, inspect_mesh
    from workbench.report.inspection_text import inspection_lines

    if not sources:
        raise UsageError("workbench inspect: name a mesh, an environment or a result")
    meshes = [source for source in sources if is_mesh(source)]
    if len(sources) > 1 and len(meshes) < len(sources):
        raise UsageError("several sources are looked at together only where all are mesh files")
    if not meshes and (units, up, forward) != (None, None, None):
        raise UsageError(
            "--units, --up and --forward are for mesh files; an environment says its own"
        )
    if is_result(Path(sources[0])):
        return _inspect_result(Path(sources[0]), as_json=as_json)
    if seat is not None:
        from workbench.study.describe.named_seat import named_seat

        made = named_seat(sources, *seat, length=units, up=up, forward=forward)
        emit(_dumped(made) if as_json else made.lines.rstrip())
        for line in made.checks:
            tell(line)
        for doubt in made.doubts:
            tell(f"warning: {doubt}")
        return 0
    with Progress() as say:
        say(f"reading {' and '.join(sources)}")
        if meshes:
            found = inspect_mesh(*sources, length=units, up=up, forward=forward)
        else:
            found = inspect_environment(sources[0])
    emit(_dumped(found) if as_json else "\n".join(inspection_lines(found)))
    return 0


def _inspect_result(path: Path, *, as_json: bool) -> int:
    """Show what a result says."""
    from workbench.files.results.result import load_result
    from workbench.report.inspection_text import result_head, verdict_lines
    from workbench.report.sentences import in_words

    rows = load_result(path)
    if as_json:
        emit(_dumped(rows))
        return 0
    for line in result_head(path, rows):
        emit_sentence(line)
    for line in verdict_lines(rows):
        emit_verdict(line)
    emit_sentence(rows.headline)
    for warning in map(in_words, rows.warnings):
        tell(f"warning: {warning}")
    return 0


@app.command
def schema(kind: str) -> int:
    """Print the JSON Schema of a kind of file, for editors.

    Parameters
    ----------
    kind
        body, comparison, encumbrance, environment, growth, population, postures, result, rules,
        simulation or study
    """
    from workbench.files.kinds import json_schemas

    known = json_schemas()
    if kind not in known:
        raise UsageError(f"no schema {kind!r}; {one_of(kind, known)}")
    emit(json_text(known[kind]))
    return 0


@app.command
def doctor(*, as_json: Json = False) -> int:
    """Say which versions and which optional parts are there."""
    from workbench.report.diagnostics import doctor_report

    report = doctor_report()
    if as_json:
        emit(_dumped(report))
    for name, words in [] if as_json else report.items():
        emit(f"{name}: {words}")
    return 0


def json_text(data: Any) -> str:
    """JSON with stable layout; letters as they are where stdout can show them all."""
    plain = "utf" not in (sys.stdout.encoding or "utf-8").lower()
    return json.dumps(data, indent=1, ensure_ascii=plain, allow_nan=False)


def _dumped(
    data: ResultFile | Inspection | NamedSeat | list[Any] | dict[str, Any],
) -> str:
    from dataclasses import asdict, is_dataclass

    if isinstance(data, (list, dict)):
        return json_text(data)
    return json_text(asdict(data) if is_dataclass(data) else data.model_dump(mode="json"))
