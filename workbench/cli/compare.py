"""The command `workbench compare`: the same people in two designs, who gains and who loses."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

from cyclopts import Parameter

from workbench.cli.progress import Progress, emit, emit_sentence, tell

if TYPE_CHECKING:
    from workbench.files.results.comparison import ComparisonFile
    from workbench.files.results.result import ResultFile
    from workbench.model.comparison import Comparison, Judged
    from workbench.model.result import ChangedPerson, PopulationFound
    from workbench.model.study import Study

__all__ = ["compare"]

Json = Annotated[bool, Parameter(name="--json", negative="", help="print data as JSON on stdout")]
Say = Callable[[str], None]
_MOST_CHANGES = 8
"""Changes that are printed."""


def compare(before: str, after: str, *, out: Path | None = None, as_json: Json = False) -> int:
    """Compare two results of a population, or two studies, with the same people: who gains, who
    loses.

    Parameters
    ----------
    before
        the folder of a result or its result.json, or a study of a population, which is run first
    after
        the same of the other design
    out
        the folder to write; out/<before>_and_<after> where not given
    """
    from workbench.files.output_folder import check_folder
    from workbench.report.comparison.page import write_comparison
    from workbench.study.accommodation.compare import compare as compared

    kept: list[str] = []
    with Progress() as say:
        if out is not None:
            check_folder(out, holds="comparison")  # before the work, not after it
        sides = [_side(source, say) for source in (before, after)]
        folder = out or Path("out") / "_and_".join(side.name for side in sides)
        check_folder(folder, holds="comparison")  # again, now that all inputs are known
        one, two = (_judged(side, say) for side in sides)
        found = compared(one.judged, two.judged)
        say("writing the page")
        made = {"before": one.inputs, "after": two.inputs}
        seen = _seen(found, one.people, two.people)
        rows = write_comparison(found, folder, provenance=made, seen=seen, tell=kept.append)
    for line in kept:
        tell(f"warning: {line}")
    for when, names in (("before", rows.only_before), ("after", rows.only_after)):
        if names:
            tell(f"warning: asked for {when} only: {', '.join(names)}")
    if as_json:
        emit(_json(rows))
    else:
        for line in rows.changes[:_MOST_CHANGES]:
            emit(f"changed  {line}")
        if len(rows.changes) > _MOST_CHANGES:
            emit(f"changed  {len(rows.changes) - _MOST_CHANGES} more, see the page")
        emit_sentence(rows.headline)
        emit(folder / "report.html")
    return 0


def _json(rows: ComparisonFile) -> str:
    """A comparison as JSON; letters as numbers where the terminal cannot show them."""
    plain = "utf" not in (sys.stdout.encoding or "utf-8").lower()
    data = rows.model_dump(mode="json")
    return json.dumps(data, indent=1, ensure_ascii=plain, allow_nan=False)


class _Side(NamedTuple):
    """One of the two designs: a result as it stands, or a study that is still to be run."""

    name: str
    source: ResultFile | Study


def _side(source: str, say: Say) -> _Side:
    """Read a source. InputError where it has nothing to do with accommodation."""
    from workbench.errors import InputError
    from workbench.files.results.result import load_result
    from workbench.files.study.reader import load_study

    say(f"reading {source}")
    path = Path(source)
    if path.is_dir() or path.suffix == ".json":
        rows = load_result(path)
        if rows.population is None:
            raise InputError(
                f"{source}: is no result of a population; two of these, or their studies, are compared"
            )
        return _Side(rows.study, rows)
    loaded = load_study(source)
    if loaded.crowd is None:
        raise InputError(
            f"{source}: is no study of a population; two of these, or their results, are compared"
        )
    return _Side(loaded.name, loaded)


class _Given(NamedTuple):
    """What a side says of its people, and the hashes of what it was made from."""

    judged: Judged
    inputs: dict[str, str]
    people: PopulationFound | None = None
    """What was found of them where the study was run now."""


def _seen(
    found: Comparison, before: PopulationFound | None, after: PopulationFound | None
) -> ChangedPerson | None:
    """Somebody who gains or loses in both designs; None unless both studies were run now."""
    from workbench.model.result import ChangedPerson
    from workbench.report.comparison.page import person_to_show
    from workbench.study.accommodation.accommodation import person_shown

    wanted = person_to_show(found)
    if wanted is None or before is None or after is None:
        return None
    row, name = wanted
    one = person_shown(before, row, name)
    two = person_shown(after, row, name)
    return None if one is None or two is None else ChangedPerson(row, one, two)


def _judged(side: _Side, say: Say) -> _Given:
    """What a side says of its people; a study is run now."""
    from workbench.files.results.result import ResultFile
    from workbench.study.accommodation.compare import evaluate_people, judged_file
    from workbench.study.run import run

    if isinstance(side.source, ResultFile):
        return _Given(judged_file(side.source), side.source.provenance.get("inputs", {}))
    say(f"measuring {side.name}")
    result = run(side.source, say=say)
    inputs = dict(result.provenance.get("inputs", {}))
    return _Given(evaluate_people(result), inputs, result.population)
