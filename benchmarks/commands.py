"""What commands cost: CPU seconds of a process with all its children, with an empty compile cache
and no index on disk, and again with both."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from benchmarks.cases import STUDIES, study_file
from benchmarks.table import Row
from benchmarks.timing import Cost, process_cost

__all__ = ["COMMANDS", "command_rows", "run_command"]

FEWER = 32
"""People of the studies about populations."""


def _fewer(role: str) -> Callable[[dict[str, Any]], None]:
    """Make a study ask fewer people."""

    def change(document: dict[str, Any]) -> None:
        document["people"][role]["population"]["people"] = FEWER

    return change


COMMANDS: Mapping[str, tuple[str, Callable[[dict[str, Any]], None] | None]] = {
    "--help": ("", None),
    "check": ("trainer_clearance", None),
    "trainer_clearance": ("trainer_clearance", None),
    "trainer_reach": ("trainer_reach", None),
    f"trainer_accommodation, {FEWER} people": ("trainer_accommodation", _fewer("pilot")),
    f"car_driver, {FEWER} people": ("car_driver", _fewer("driver")),
    "trainer_crash": ("trainer_crash", None),
}
"""The study that a command is about, and how it is changed before."""


def run_command(name: str, folder: Path, caches: Path) -> Cost:
    """Run one of COMMANDS in a new process, its output under a folder.

    Raises
    ------
    ValueError
        If it ends otherwise than with verdicts.
    """
    study, change = COMMANDS[name]
    path = study_file(study, change, folder) if change else STUDIES / f"{study}.yaml"
    words = {"--help": ["--help"], "check": ["check", str(path)]}
    asked = words.get(name, ["run", str(path), "--out", str(folder / "out")])
    kept = {"NUMBA_CACHE_DIR": str(caches / "compiled"), "WORKBENCH_CACHE": str(caches / "index")}
    cost = process_cost(["-m", "workbench", *asked], kept, folder / "said.txt")
    if cost.code not in (0, 1):
        raise ValueError(f"{name}: ended with {cost.code}:\n{cost.out}")
    return cost


def command_rows(names: tuple[str, ...] = tuple(COMMANDS)) -> Iterator[Row]:
    """Yield the cost of each command by itself, cold and warm."""
    for name in names:
        with tempfile.TemporaryDirectory() as place:
            caches = Path(place) / "caches"
            costs = []
            for run in ("cold", "warm"):
                folder = Path(place) / run
                folder.mkdir()
                costs.append(run_command(name, folder, caches))
        cold, warm = costs
        for figure, cost in (("first run, nothing compiled", cold), ("warm", warm)):
            words = f"{cost.wall:.1f} s by the clock, {cost.memory:.2f} GB"
            yield Row(figure, name, cost.cpu, "s", words)
        yield Row("first run less a warm one", name, cold.cpu - warm.cpu, "s", "")
