"""Keep what the workbench answers in one file, and compare two such files.

    python tools/snapshot.py make before.json
    python tools/snapshot.py compare before.json after.json --explain accepted.txt

`make` asks the questions of `snapshot_answers.py` and writes every answer under a name that says
the question, such as `clearance/adult_male/trainer/left/driving/H/canopy`. The names speak of
bodies, postures, studies, roles, cases and criteria, never of a class or a module. When the package
or its study format changes, only `snapshot_answers.py` changes and the stored answers keep their
names. `--only` asks some of the questions; each is a section of the file.

`compare` lists the answers that are in one file only, the numbers that differ and the flags that
flip, of the sections that both files have. It exits with 0 where there is no difference or all are
explained, and with 1 otherwise. The text file of `--explain` holds one accepted difference a line,
in three columns:

    # names (with * and ?)    | by at most | reason
    reach/trainer_reach/*/miss_mm | 0.02 | the search starts at the posture of the case
    verdict/*/where               | any  | sentences were rewritten

`--solved` allows what a solver that takes other steps may differ by, 1e-9 m and 1e-7 rad; flags and
texts must be equal. A number in the second column accepts numbers that differ by no more than this. `any` accepts every
difference: also flags, texts and answers that are in one file only.
"""

from __future__ import annotations

import argparse
import gzip
import json
import math
import os
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

FORMAT = 1
UNITS = "lengths in mm, angles in degrees, times in s, masses in kg, shares from 0 to 1, unless a name says otherwise"
DECIMALS = 10
"""Decimals of the numbers that are written. It is one more than the default tolerance can see."""
TOLERANCE = 1e-9
"""Two numbers are equal where they differ by no more than this, or by this part of the larger
one."""
SOLVED = 1e-6
SOLVED_DEGREES = 6e-6
"""By how much more answers of iterations may differ with `--solved`: lengths in mm, and all that has
no unit, by 1e-9 m; what ends in _deg by 1e-7 rad."""
KINDS = ("only in old", "only in new", "flag", "number", "text")

Answers = Mapping[str, Any]
"""Answers by name: a flag, a number, a text, None (does not apply), or a list of these."""


@dataclass(frozen=True)
class Difference:
    """One answer that is not the same in both files."""

    name: str
    kind: str
    """One of KINDS."""
    words: str
    """Both answers, or what differs between them."""
    size: float = math.nan
    """By how much a number differs; of a list of numbers the largest difference."""
    reason: str = ""
    """Why the difference is accepted; empty where it is not."""


@dataclass(frozen=True)
class Explanation:
    """A line of the file of accepted differences."""

    pattern: str
    at_most: float
    """The largest difference of a number that is accepted; infinite where anything is."""
    reason: str

    def covers(self, found: Difference) -> bool:
        """Whether this line accepts a difference."""
        if not fnmatchcase(found.name, self.pattern):
            return False
        return math.isinf(self.at_most) or (found.kind == "number" and found.size <= self.at_most)


# ---- the file
# ------------------------------------------------------------------------------------------------------


def flat(answers: Answers, above: str = "") -> Iterator[tuple[str, Any]]:
    """Name and answer of every leaf of nested answers, numbers rounded to DECIMALS."""
    for key, value in answers.items():
        name = f"{above}/{key}" if above else key
        if isinstance(value, Mapping):
            yield from flat(value, name)
        else:
            yield name, _plain(value)


def _plain(value: Any) -> Any:
    """A value that JSON can hold; None for a number that is not finite."""
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return round(value, DECIMALS) + 0.0 if math.isfinite(value) else None
    if value is None or isinstance(value, (bool, int, str)):
        return value
    return _plain(value.tolist())  # a NumPy number or array


def text_of(sections: Mapping[str, Answers]) -> str:
    """The file's text: in each section answers sorted by name, a line for those that share all but
    the last part."""
    head = f'"format": {FORMAT},\n"units": {_json(UNITS)}'
    rows = (
        f"{_json(section)}: {{\n{_lines(sections[section])}\n}}" for section in sorted(sections)
    )
    return "{\n" + head + ',\n"answers": {\n' + ",\n".join(rows) + "\n}\n}\n"


def _lines(answers: Answers) -> str:
    lines: dict[str, dict[str, Any]] = defaultdict(dict)
    for name, value in flat(answers):
        above, _, last = name.rpartition("/")
        if last in lines[above]:
            raise ValueError(f"two answers are named {name!r}")
        lines[above][last] = value
    return ",\n".join(
        f"{_json(above)}: {_json(dict(sorted(lines[above].items())))}" for above in sorted(lines)
    )


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def write(path: Path, sections: Mapping[str, Answers]) -> None:
    """Write sections of answers, compressed where the file's name ends in .gz; the same answers
    give the same bytes."""
    data = text_of(sections).encode()
    if path.suffix == ".gz":
        data = gzip.compress(data, mtime=0)
    partial = path.with_name(path.name + ".partial")
    partial.write_bytes(data)
    partial.replace(path)


def read(path: Path) -> dict[str, dict[str, Any]]:
    """Answers by name, section by section, of a file that `make` wrote; ValueError where it is
    another file."""
    data = path.read_bytes()
    content = json.loads(gzip.decompress(data) if path.suffix == ".gz" else data)
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ValueError(
            f"{path}: not a snapshot of format {FORMAT}; make one by: python tools/snapshot.py make FILE"
        )
    return {section: dict(flat(answers)) for section, answers in content["answers"].items()}


# ---- the comparison
# ------------------------------------------------------------------------------------------------


def together(sections: Mapping[str, Answers], wanted: Iterable[str]) -> Answers:
    """The answers of some sections by name."""
    return {name: value for section in wanted for name, value in sections[section].items()}


def differences(
    old: Answers, new: Answers, *, tolerance: float = TOLERANCE, solved: bool = False
) -> Iterator[Difference]:
    """What differs between two sets of answers, by name; solved: as answers of iterations may."""
    for name in sorted(old.keys() | new.keys()):
        if name not in new:
            yield Difference(name, "only in old", _short(old[name]))
        elif name not in old:
            yield Difference(name, "only in new", _short(new[name]))
        else:
            more = (SOLVED_DEGREES if name.endswith("_deg") else SOLVED) if solved else 0.0
            found = difference(name, old[name], new[name], tolerance, more)
            if found is not None:
                yield found


def difference(
    name: str, old: Any, new: Any, tolerance: float, more: float = 0.0
) -> Difference | None:
    """How two answers of one name differ; None where they do not, or by no more than `more`."""
    if old == new and not _mixed(old, new):
        return None
    if isinstance(old, list) and isinstance(new, list):
        return _of_lists(name, old, new, tolerance, more)
    if _is_number(old) and _is_number(new):
        if _equal(old, new, tolerance) or abs(new - old) <= more:
            return None
        return Difference(name, "number", f"{old!r} -> {new!r}", abs(new - old))
    kind = "text" if isinstance(old, str) and isinstance(new, str) else "flag"
    return Difference(name, kind, f"{_short(old)} -> {_short(new)}")


def _of_lists(
    name: str, old: list[Any], new: list[Any], tolerance: float, more: float
) -> Difference | None:
    """How two lists differ: entry by entry where they are as long as each other, else by what they
    hold."""
    if len(old) != len(new) or all(isinstance(item, str) for item in old + new):
        gone = list((Counter(map(str, old)) - Counter(map(str, new))).elements())
        come = list((Counter(map(str, new)) - Counter(map(str, old))).elements())
        order = "" if gone or come else ", in another order"
        words = f"{len(old)} -> {len(new)} entries{order}; only in old: {_short(gone)}, only in new: {_short(come)}"
        return Difference(name, "text", words)
    found = [difference(name, a, b, tolerance, more) for a, b in zip(old, new, strict=True)]
    wrong = [(index, one) for index, one in enumerate(found) if one is not None]
    if not wrong:
        return None
    kinds = {one.kind for _, one in wrong}
    kind = next(kind for kind in ("flag", "text", "number") if kind in kinds)
    index, worst = max(wrong, key=lambda row: (row[1].kind == kind, row[1].size))
    words = f"{len(wrong)} of {len(old)} entries, entry {index}: {worst.words}"
    return Difference(name, kind, words, worst.size if kind == "number" else math.nan)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _mixed(old: Any, new: Any) -> bool:
    """Whether a flag stands against a number, which Python takes for equal."""
    return isinstance(old, bool) != isinstance(new, bool)


def _equal(old: float, new: float, tolerance: float) -> bool:
    return abs(new - old) <= tolerance * max(1.0, abs(old), abs(new))


def _short(value: Any, most: int = 90) -> str:
    text = _json(value)
    return text if len(text) <= most else text[: most - 3] + "..."


# ---- accepted differences
# ------------------------------------------------------------------------------------------


def read_explanations(path: Path) -> list[Explanation]:
    """The lines of a file of accepted differences; ValueError with the line for one that cannot be
    read."""
    found = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        columns = [column.strip() for column in line.split("|", 2)]
        if len(columns) < 3 or not all(columns):
            raise ValueError(
                f"{path}:{number}: three columns are needed, 'names | by at most | reason', got {line!r}"
            )
        found.append(Explanation(columns[0], _at_most(columns[1], f"{path}:{number}"), columns[2]))
    return found


def _at_most(word: str, where: str) -> float:
    if word == "any":
        return math.inf
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not 0 <= value < math.inf:
        raise ValueError(f"{where}: the second column is a positive number or 'any', got {word!r}")
    return value


def explained(found: Iterable[Difference], known: Sequence[Explanation]) -> Iterator[Difference]:
    """The differences with the reason of the first explanation that covers each."""
    for one in found:
        reason = next((row.reason for row in known if row.covers(one)), "")
        yield replace(one, reason=reason)


def idle(found: Sequence[Difference], known: Iterable[Explanation]) -> list[Explanation]:
    """The explanations that cover no difference."""
    return [row for row in known if not any(row.covers(one) for one in found)]


# ---- the report
# ----------------------------------------------------------------------------------------------------


def report(
    old: Answers, new: Answers, found: Sequence[Difference], *, most: int = 10
) -> Iterator[str]:
    """The lines of a comparison: a table with a row for each first part of a name, then the first
    of each kind."""
    by_group: dict[str, list[Difference]] = defaultdict(list)
    for one in found:
        by_group[one.name.split("/")[0]].append(one)
    counts = Counter(name.split("/")[0] for name in old.keys() | new.keys())
    yield "".join(f"{head:>13}" for head in ["group", "answers", *KINDS, "largest", "explained"])
    for group in sorted(counts):
        rows = by_group[group]
        kinds = Counter(row.kind for row in rows)
        largest = max((row.size for row in rows if row.kind == "number"), default=0.0)
        cells = [
            group,
            counts[group],
            *(kinds[kind] for kind in KINDS),
            f"{largest:.3g}" if largest else "0",
        ]
        yield "".join(f"{cell:>13}" for cell in [*cells, sum(bool(row.reason) for row in rows)])
    for group in sorted(by_group):
        for kind in KINDS:
            rows = [row for row in by_group[group] if row.kind == kind and not row.reason]
            rows.sort(key=lambda row: -row.size if kind == "number" else 0.0)
            yield from (f"{kind}: {row.name}: {row.words}" for row in rows[:most])
            if len(rows) > most:
                yield f"{kind}: {group}: {len(rows) - most} more"


# ---- the command
# ---------------------------------------------------------------------------------------------------


def _make(arguments: argparse.Namespace) -> int:
    os.environ["WORKBENCH_CACHE"] = "off"  # an answer must not come from what an older version kept
    from snapshot_answers import COLLECTORS, collected

    wanted = (
        [name.strip() for name in arguments.only.split(",")] if arguments.only else list(COLLECTORS)
    )
    unknown = [name for name in wanted if name not in COLLECTORS]
    if unknown:
        print(
            f"--only: no questions are called {', '.join(unknown)}; there are {', '.join(COLLECTORS)}",
            file=sys.stderr,
        )
        return 2
    answers = collected(wanted, say=lambda text: print(text, file=sys.stderr, flush=True))
    write(arguments.file, answers)
    print(f"{arguments.file}: {sum(1 for _ in flat(answers))} answers in {len(answers)} sections")
    return 0


def _compare(arguments: argparse.Namespace) -> int:
    try:
        before = read(arguments.old)
        after = read(arguments.new)
        known = read_explanations(arguments.explain) if arguments.explain else []
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 3
    common = sorted(before.keys() & after.keys())
    for section in sorted(before.keys() ^ after.keys()):
        print(f"not compared: the section {section} is in one file only")
    if not common:
        print("the files have no section in common", file=sys.stderr)
        return 3
    old = together(before, common)
    new = together(after, common)
    differing = differences(old, new, tolerance=arguments.tolerance, solved=arguments.solved)
    found = list(explained(differing, known))
    for line in report(old, new, found, most=arguments.most):
        print(line)
    for row in idle(found, known):
        print(f"explains nothing: {row.pattern} ({row.reason})")
    open_ = sum(not one.reason for one in found)
    print(f"{len(found)} differences, {len(found) - open_} explained, {open_} not")
    return 1 if open_ else 0


def main(words: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    parser = argparse.ArgumentParser(
        prog="snapshot.py", description=(__doc__ or "").splitlines()[0]
    )
    commands = parser.add_subparsers(dest="command", required=True)
    make = commands.add_parser("make", help="write the answers of the present code")
    make.add_argument("file", type=Path, help="the file to write, .json or .json.gz")
    make.add_argument("--only", help="some of the sections, with commas between")
    make.set_defaults(run=_make)
    compare = commands.add_parser(
        "compare", help="compare two files; exit code 1 where they differ"
    )
    compare.add_argument("old", type=Path)
    compare.add_argument("new", type=Path)
    compare.add_argument("--explain", type=Path, help="a file of accepted differences")
    compare.add_argument(
        "--tolerance", type=float, default=TOLERANCE, help="numbers may differ by this much"
    )
    compare.add_argument(
        "--solved", action="store_true", help="allow 1e-9 m and 1e-7 rad, as of other iterations"
    )
    compare.add_argument(
        "--most", type=int, default=10, help="differences listed for each group and kind"
    )
    compare.set_defaults(run=_compare)
    arguments = parser.parse_args(words)
    result: int = arguments.run(arguments)
    return result


if __name__ == "__main__":
    sys.exit(main())
