"""The command `workbench compare`: the same people in two designs, who gains and who loses."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from workbench.cli_progress import Progress, emit, tell

if TYPE_CHECKING:
    from workbench.model.comparison import Judged

__all__ = ["compare"]

Json = Annotated[bool, Parameter(name="--json", negative="", help="print data as JSON on stdout")]
Given = tuple["Judged", dict[str, str]]


def compare(before: str, after: str, *, out: Path | None = None, as_json: Json = False) -> int:
    """Compare two accommodation results, or two studies, with the same people: who gains, who loses.

    Parameters
    ----------
    before
        the folder of a result or its result.json, or an accommodation study, which is run first
    after
        the same of the other design
    out
        the folder to write; out/<before>_and_<after> where not given
    """
    from workbench.files.comparison_results import MARK
    from workbench.files.results import check_folder
    from workbench.report.comparison.page import write_comparison
    from workbench.study.accommodation.compare import compare as compared

    with Progress() as say:
        if out is not None:
            check_folder(out, mark=MARK)  # before the work, not after it
        one, first = _judged(before, say)
        two, second = _judged(after, say)
        found = compared(one, two)
        folder = out or Path("out") / f"{one.name}_and_{two.name}"
        check_folder(folder, mark=MARK)
        say("writing the page")
        made = {"before": first, "after": second}
        rows = write_comparison(found, folder, provenance=made)
    for when, names in (("before", rows.only_before), ("after", rows.only_after)):
        if names:
            tell(f"warning: asked for {when} only: {', '.join(names)}")
    if as_json:
        plain = "utf" not in (sys.stdout.encoding or "utf-8").lower()
        emit(json.dumps(rows.model_dump(mode="json"), indent=1, ensure_ascii=plain, allow_nan=False))
    else:
        emit(rows.headline)
        emit(folder / "report.html")
    return 0


def _judged(source: str, say: Callable[[str], None]) -> Given:
    """What a source says of its people, and the hashes of what it was made from: of a result as it stands, of a study
    run now."""
    from workbench.errors import InputError
    from workbench.files.accommodation.results import load_accommodation_result
    from workbench.model.accommodation import Accommodation
    from workbench.study.accommodation.compare import judged, judged_file
    from workbench.study.run import load, run

    path = Path(source)
    if path.is_dir() or path.suffix == ".json":
        say(f"reading {source}")
        rows = load_accommodation_result(path)
        return judged_file(rows), rows.provenance.get("inputs", {})
    say(f"reading {source}")
    loaded = load(source)
    if loaded.kind != "accommodation":
        raise InputError(f"{source}: is a {loaded.kind} study; accommodation studies, or their results, are compared")
    say(f"measuring {loaded.name}")
    result = run(loaded, say=say)
    assert isinstance(result, Accommodation)
    return judged(result), dict(result.provenance.get("inputs", {}))
