"""What a person of a population costs in cockpits that were made elsewhere, beside the product's own.

`cockpits/` describes real meshes of ../shared as a user would, each named in its first line; `workbench new` writes the population
study of each. Of the light aircraft it is a study that a user wrote. A person costs what the command
takes more for many people than for few, proposed changes included.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks.cases import STUDIES
from benchmarks.table import Row
from benchmarks.timing import Cost, process_cost

__all__ = ["cockpit_rows"]

HERE = Path(__file__).parent / "cockpits"
SHARED = Path(__file__).parents[2] / "shared"
AIRCRAFT = SHARED / "cases" / "grob"
FEW = 16
MANY = 64
"""People of the two runs whose difference is told."""
OWN = ("trainer_accommodation", "car_driver")


def cockpit_rows(people: int = MANY) -> Iterator[Row]:
    """Yield the CPU time of a person in each cockpit, and that of one man in the aircraft."""
    for name in OWN:
        yield from _rows(name, STUDIES / f"{name}.yaml", people)
    if not AIRCRAFT.exists():
        return
    yield from _rows("light aircraft", AIRCRAFT / "fit.yaml", people)
    for path in sorted(HERE.glob("*.yaml")):
        yield from _rows(path.stem.replace("_", " "), path, people)
    with tempfile.TemporaryDirectory() as place:
        _cost(AIRCRAFT / "study.yaml", Path(place))
        cost = _cost(AIRCRAFT / "study.yaml", Path(place))
    yield Row("one man", "light aircraft", cost.cpu, "s", f"{cost.wall:.1f} s by the clock")


def _rows(name: str, path: Path, people: int) -> Iterator[Row]:
    """Yield what a person costs in one cockpit: an environment's, or a study's."""
    with tempfile.TemporaryDirectory() as place:
        few, many = (
            _cost(_of_people(path, count, Path(place)), Path(place) / str(count), times=2)
            for count in (min(FEW, people // 2), people)
        )
        count = people - min(FEW, people // 2)
    each = 1000 * (many.cpu - few.cpu) / count
    words = f"{many.cpu:.1f} s for {people} people, {many.wall:.1f} s by the clock"
    yield Row("a person of a population", name, each, "ms", words)


def _of_people(path: Path, people: int, folder: Path) -> Path:
    """Write the population study of an environment, or a study with so many people."""
    found = folder / f"{path.stem}_{people}.yaml"
    if path.parent == HERE:
        mesh = path.read_text(encoding="utf-8").split("\n")[0].removeprefix("# mesh: ")
        for source in (path, SHARED / "data" / "environments" / mesh):
            shutil.copy(source, folder)
        asked = ["new", str(folder / path.name), "--people", str(people), "-o", str(found)]
        process_cost(["-m", "workbench", *asked], {}, folder / "said.txt")
        return found.with_name(f"{found.stem}_people.yaml")
    text = re.sub(r"people: \d+", f"people: {people}", path.read_text(encoding="utf-8"))
    near = re.sub(r"environment: (\S+\.yaml)", rf"environment: {path.parent}/\1", text)
    found.write_text(near, encoding="utf-8")
    return found


def _cost(study: Path, folder: Path, times: int = 1) -> Cost:
    """Run a study, the last of some times; ValueError where it ends without verdicts."""
    folder.mkdir(exist_ok=True)
    for _ in range(times):
        asked = ["run", str(study), "--out", str(folder / "out")]
        cost = process_cost(["-m", "workbench", *asked], {}, folder / "said.txt")
    if cost.code not in (0, 1):
        raise ValueError(f"{study}: ended with {cost.code}:\n{cost.out}")
    return cost
