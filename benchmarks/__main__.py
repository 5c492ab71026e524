"""One table of what the workbench costs, where its users are: `python -m benchmarks`.

    python -m benchmarks [SECTION ...] [--all] [--quick] [--write]

Sections: places, meshes, pose, index, peers, batches, people, cockpits, commands; all of them where none is
named. It takes some twenty-five minutes on an idle machine of two cores. --all asks everybody,
where else fewer people are asked and the row says so: more than an hour. --quick takes the
least of everything, to see that all of it works. --write puts what was taken into
docs/benchmarks.md; sections that are not named stay as they are there.

CPU time of one core, but people and large batches by what the row says. Everything is warmed before
it is timed, except commands, which are run cold and warm. Libraries that are not installed are left
out with a word: pip install '.[bench]'.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.batches import POSES, batch_rows
from benchmarks.cases import BODIES, in_cockpit, seated_in
from benchmarks.clearance import index_rows, mesh_rows, one_pose_rows, place_rows
from benchmarks.cockpits import cockpit_rows
from benchmarks.commands import command_rows
from benchmarks.peers import peer_rows
from benchmarks.people import EVERYBODY, people_rows
from benchmarks.table import Row, Section, machine, page, sections_of
from benchmarks.timing import one_core
from benchmarks.workload import SIZES

__all__ = ["main", "sections"]

PAGE = Path(__file__).parents[1] / "docs" / "benchmarks.md"


@dataclass(frozen=True)
class Effort:
    """How much is asked: poses, of large batches too; people, and people of a reach map; spheres of
    the bodies in places and in meshes; sizes of meshes; commands by name, all if empty."""

    poses: int = 1000
    batch: int = POSES
    people: int = 512
    mapped: int = 128
    points: int = 2000
    seated: tuple[str, ...] = tuple(BODIES)
    spheres: tuple[str, ...] = ("399", "1500")
    sizes: tuple[str, ...] = tuple(SIZES)
    commands: tuple[str, ...] = ()


EVERYTHING = Effort(people=EVERYBODY, mapped=EVERYBODY)
QUICK = Effort(
    poses=64,
    batch=4096,
    people=8,
    mapped=4,
    points=60,
    seated=("957",),
    spheres=("1500",),
    sizes=("2k",),
    commands=("--help", "check"),
)


def _index(effort: Effort) -> Iterator[Row]:
    cases = [seated_in(place, "957", 64) for place in ("trainer", "compact_car")]
    for kind in ("curved", "flat"):
        cases += [in_cockpit(kind, size, "399", 64) for size in effort.sizes]
    return index_rows(cases)


def _peers(effort: Effort) -> Iterator[Row]:
    size = "50k" if "50k" in effort.sizes else effort.sizes[0]
    for kind in ("flat", "curved"):
        yield from peer_rows(in_cockpit(kind, size, "1500", effort.poses))
    yield from peer_rows(seated_in("trainer", "957", effort.poses), ["by segment"])


@dataclass(frozen=True)
class Topic:
    """A section to be: its title, words on how it is taken, what yields its rows, and whether on one
    core."""

    title: str
    words: str
    rows: Callable[[Effort], Iterator[Row]]
    one_core: bool = True


TOPICS = {
    "places": Topic(
        "Seated in the product's places",
        "Poses around that of the study, on the seat, in permitted contact with solid parts, asked "
        "as the commands ask. The real vehicle has open parts only.",
        lambda effort: place_rows(effort.seated, poses=effort.poses),
    ),
    "meshes": Topic(
        "Curved and flat faces",
        "Made cockpits; five parts are solid. Flat faces are meshed finely and merge into polygons.",
        lambda effort: mesh_rows(effort.sizes, effort.spheres, poses=effort.poses),
    ),
    "pose": Topic(
        "One pose, one answer",
        "One call a pose, the Python around it included.",
        lambda effort: one_pose_rows("trainer", "957", poses=min(effort.poses, 20)),
    ),
    "index": Topic(
        "Index",
        "What the first call about an environment takes more than the second.",
        _index,
    ),
    "peers": Topic(
        "Other libraries",
        "Engines in turn on the same poses in one process, every part open for all of them, "
        "this project included. Batches, limits and managers are used where a library has them. In "
        "the trainer whoever sits touches an open seat at once, so that `any` asks for nothing.",
        _peers,
    ),
    "batches": Topic(
        "Large batches",
        "A person of 957 spheres in the trainer, by segment with permitted contact, on one core.",
        lambda effort: batch_rows(effort.batch),
    ),
    "people": Topic(
        "Populations",
        "The study trainer_accommodation about everybody who was measured, without its map; by the "
        "clock on all cores.",
        lambda effort: people_rows(effort.people, mapped=effort.mapped, points=effort.points),
        one_core=False,
    ),
    "cockpits": Topic(
        "Cockpits of others",
        "A person of a population: CPU seconds of the whole command for many people less those for "
        "few, a person, proposed changes included, everything compiled. The first two are the "
        "product's own; the others are real meshes that nobody here made.",
        lambda effort: cockpit_rows(min(effort.people, 64)),
        one_core=False,
    ),
    "commands": Topic(
        "Commands",
        "CPU seconds of a process with its children. The first run has an empty compile cache and "
        "no index.",
        lambda effort: command_rows(*([effort.commands] if effort.commands else [])),
        one_core=False,
    ),
}


def sections(names: list[str], effort: Effort) -> Iterator[Section]:
    """Take the figures of some TOPICS by name, and say on the way how far it is."""
    for name in names:
        topic = TOPICS[name]
        begin = time.perf_counter()
        rows = []
        for row in _on_one_core(topic, effort) if topic.one_core else topic.rows(effort):
            print(row, file=sys.stderr, flush=True)
            rows.append(row)
        print(f"{name}: {time.perf_counter() - begin:.0f} s", file=sys.stderr, flush=True)
        yield Section(topic.title, topic.words, rows, machine())


def _on_one_core(topic: Topic, effort: Effort) -> Iterator[Row]:
    with one_core():
        yield from topic.rows(effort)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("section", nargs="*", metavar="SECTION", help=", ".join(TOPICS))
    parser.add_argument("--all", action="store_true", help="everybody")
    parser.add_argument("--quick", action="store_true", help="the least of everything")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks.md")
    options = parser.parse_args()
    unknown = [name for name in options.section if name not in TOPICS]
    if unknown:
        parser.error(f"no section {', '.join(unknown)}; valid: {', '.join(TOPICS)}")
    if options.write and options.quick:
        parser.error("--quick takes too little to write it")
    return options


def main() -> None:
    """Take the figures, print the page, and write it where that is asked for."""
    options = _options()
    effort = EVERYTHING if options.all else QUICK if options.quick else Effort()
    with tempfile.TemporaryDirectory() as folder:
        os.environ.setdefault("WORKBENCH_CACHE", folder)
        found = list(sections(options.section or list(TOPICS), effort))
    text = page(found, whole=not options.section)
    print(text)
    if options.write:
        PAGE.write_text(_with_the_others(found), encoding="utf-8")


def _with_the_others(taken: list[Section]) -> str:
    """The page with the sections that were taken, and the others as they are there."""
    old = sections_of(PAGE.read_text(encoding="utf-8")) if PAGE.exists() else []
    by_title = {section.title: section for section in [*old, *taken]}
    titles = [topic.title for topic in TOPICS.values()]
    return page([by_title[title] for title in titles if title in by_title])


if __name__ == "__main__":
    main()
