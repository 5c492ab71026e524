"""The raw public files of ANSUR II (Gordon et al. 2014, NATICK/TR-15/007), as the US Army published
them.

Their traps: latin-1; lengths in mm, but `weightkg` in 0.1 kg and `interpupillarybreadth` in 0.1 mm;
`subjectid` in one file is `SubjectId` in the other; there is no acromial or cervicale height
sitting, which is derived from three columns.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.errors import InputError, UsageError, one_of, printable
from workbench.files.file_errors import BYTE_ORDER_MARK, read_whole
from workbench.files.schema import metres_in
from workbench.model.arrays import Bools, Floats
from workbench.model.population import MASS, MEASURES, SEXES, Population, check_measures
from workbench.model.units import plain

__all__ = [
    "BODY_MASS_INDEX",
    "MEDIAN_INDEX",
    "measures_in",
    "odd_masses",
    "raw_columns",
    "read_ansur",
]

MOST_TOLD = 20
MOST_BYTES = 256 * 2**20
_SUBJECT = "subjectid"
_SEX = "gender"
_MILLIMETRES = 0.001
_DIGITS = 9
_LARGEST = 1e6
_UNITS = {"weightkg": 0.1, "interpupillarybreadth": 0.0001}
BODY_MASS_INDEX = (12.0, 70.0)
"""Least and greatest body mass index [kg/m^2] of a person, mass / stature^2."""
MEDIAN_INDEX = (13.0, 42.0)
"""The same of the median of several people: of five-year-olds it is 15, of adults 21 to 33."""
_SEVERAL = 3
_STATED = re.compile(rf"({'|'.join(MEASURES)})_(mm|cm|m|in|kg)")
"""A name of a column, and the unit that it may end with, as `workbench people draw --csv` writes it."""
_OWN = {"sex": _SEX, "label": _SUBJECT}
_LEGS = "stature less sitting height"
# by hand; in ANSUR II no part is longer than 0.96 of its whole, the legs of nobody shorter than 1.4
# of the knee's height
_WHOLES = {
    "sitting_height": "stature",
    "acromial_height": "stature",
    "cervicale_height": "stature",
    "trochanterion_height": "stature",
    "crotch_height": "stature",
    "lateral_femoral_epicondyle_height": "trochanterion_height",
    "lateral_malleolus_height": "lateral_femoral_epicondyle_height",
    "eye_height_sitting": "sitting_height",
    "cervicale_height_sitting": "eye_height_sitting",
    "acromial_height_sitting": "eye_height_sitting",
    "elbow_rest_height": "acromial_height_sitting",
    "thigh_clearance": "knee_height_sitting",
    "popliteal_height": "knee_height_sitting",
    "knee_height_sitting": _LEGS,
    "buttock_popliteal_length": "buttock_knee_length",
    "biacromial_breadth": "bideltoid_breadth",
    "radiale_stylion_length": "forearm_hand_length",
    "forearm_center_of_grip_length": "forearm_hand_length",
    "forearm_hand_length": "thumb_tip_reach",
    "hand_length": "forearm_hand_length",
    "hand_breadth": "hand_length",
    "foot_breadth_horizontal": "foot_length",
    "interpupillary_breadth": "head_breadth",
    "tragion_top_of_head": "sitting_height",
}
"""Measures, and what each is a part of: nobody's is as long as that."""
_SITTING = {
    "acromial_height_sitting": "acromialheight",
    "cervicale_height_sitting": "cervicaleheight",
}


@dataclass(frozen=True)
class _Table:
    """A CSV file: its cells by the lower-case name of their column, the line of each row, and the
    units [m; kg] of the columns that state one."""

    path: Path
    columns: dict[str, list[str]]
    lines: list[int]
    units: dict[str, float]


def read_ansur(
    *paths: str | Path,
    measures: Sequence[str] = tuple(MEASURES),
    unit: float = _MILLIMETRES,
    weights: str | None = None,
) -> Population:
    """Read one raw public CSV file or more of ANSUR II, or of the same layout, into one Population.

    measures: those wanted; other columns need not be there. A file of the same layout may call its
    columns by the names of the measures too, give lengths in another unit [m], masses as `mass`
    [kg], say the unit of a column in its name (`stature_mm`), as `workbench people draw --csv` writes
    them, and in a column `weights` for how many people each row stands. InputError names missing
    columns, and for absurd values their line and column; a mass is judged against the stature, and a
    measure against what it is a part of (eyes below the top of the head).
    """
    if not paths:
        raise UsageError("name one CSV file or more")
    wanted = check_measures(measures)
    if not wanted:
        raise UsageError("measures: expected one measure at least, got none")
    parts = [_people(_table(Path(path)), wanted, unit, weights) for path in paths]
    return Population(
        names=wanted,
        sex=np.concatenate([part.sex for part in parts]),
        weight=np.concatenate([part.weight for part in parts]),
        measures=np.concatenate([part.measures for part in parts]),
        source=", ".join(part.source for part in parts),
        labels=tuple(label for part in parts for label in part.labels),
    )


def measures_in(*paths: str | Path) -> tuple[str, ...]:
    """The measures that all of these files have; InputError where one cannot be read."""
    tables = [_table(Path(path)) for path in paths]
    return tuple(
        m for m in MEASURES if all(set(_parts(m, t.columns)) <= set(t.columns) for t in tables)
    )


def raw_columns(measures: Sequence[str]) -> tuple[str, ...]:
    """The columns of the public files that hold people, their sex and all of these measures."""
    parts = [part for measure in check_measures(measures) for part in _parts(measure, ())]
    return tuple(dict.fromkeys([_SUBJECT, _SEX, *parts]))


def _parts(measure: str, columns: Container[str]) -> tuple[str, ...]:
    """The columns that a measure is made of: itself, or sitting height - stature + height
    standing."""
    name = measure.replace("_", "")
    if measure in _SITTING and name not in columns:
        return ("sittingheight", "stature", _SITTING[measure])
    return ("weightkg",) if measure == MASS and name not in columns else (name,)


def _people(
    table: _Table, measures: tuple[str, ...], unit: float, weights: str | None
) -> Population:
    """The people of a table. unit: of its lengths [m]; weights: the column of their weights."""
    weighed = [] if weights is None else [weights.lower().replace("_", "")]
    columns_of = {measure: _parts(measure, table.columns) for measure in measures}
    parts = [part for columns in columns_of.values() for part in columns]
    needed = dict.fromkeys([_SEX, *weighed, *parts])
    missing = [column for column in needed if column not in table.columns]
    if missing:
        raise InputError(f"{table.path}:1: missing columns: {', '.join(missing)}")
    faults: list[str] = []
    sex = [_sex(table, row, cell, faults) for row, cell in enumerate(table.columns[_SEX])]
    raw = {name: _numbers(table, name, faults) for name in needed if name != _SEX}
    values = _measured(table, columns_of, raw, unit, faults)
    weight = np.ones(len(table.lines))
    for column in weighed:
        weight = raw[column]
        faults += [
            f"{table.path}:{table.lines[row]}: {column}: a weight is positive, got {weight[row]:g}"
            for row in np.flatnonzero(weight <= 0)
        ]
    if faults:
        more = len(faults) - MOST_TOLD
        last = [f"{table.path}: … and {more} more"] if more > 0 else []
        raise InputError(faults[:MOST_TOLD] + last)
    labels = tuple(table.columns.get(_SUBJECT, [str(line) for line in table.lines]))
    return Population(measures, np.array(sex), weight, values, table.path.name, labels)


def _measured(
    table: _Table,
    columns_of: dict[str, tuple[str, ...]],
    raw: dict[str, Floats],
    unit: float,
    faults: list[str],
) -> Floats:
    """(P, M) the measures [m; kg for mass] from the columns that each is made of.

    raw: the numbers of the columns as recorded; unit: that of lengths [m]; faults: to which those
    of values that are no person's are added.
    """
    values: dict[str, Floats] = {}
    bad: dict[str, Bools] = {}
    # what others are derived from is judged first, so that its fault is reported once
    for measure in sorted(columns_of, key=_SITTING.__contains__):
        parts = columns_of[measure]
        first, *others = parts
        # in whole millimetres first, then the nearest double, so that equal people stay equal
        recorded = raw[first] - raw[others[0]] + raw[others[1]] if others else raw[first]
        sizes = recorded * table.units.get(first, _unit(first, unit))
        # absurd values are refused below, and may be too large to be rounded
        sane = np.abs(sizes) < _LARGEST
        values[measure] = np.where(sane, np.round(np.where(sane, sizes, 0.0), _DIGITS), sizes)
        known = np.any([bad.get(part, np.isnan(raw[part])) for part in parts], axis=0)
        absurd = _absurd(measure, values[measure])
        bad["+".join(parts)] = known | absurd
        rows = np.flatnonzero(absurd & ~known).tolist()
        faults += [_absurd_words(table, row, measure, parts, values[measure]) for row in rows]
    if not faults and {MASS, "stature"} <= values.keys():
        faults += _mass_faults(table, columns_of[MASS][0], values[MASS], values["stature"])
    if not faults:
        faults += _part_faults(table, columns_of, values)
    return np.stack([values[measure] for measure in columns_of], axis=1)


def odd_masses(index: Floats, middle: float | None) -> list[int]:
    """Return which of (P,) body mass indices [kg/m^2] are no person's; where all could be but the
    median of several people is no such median, the one nearest to it.

    middle: the median, None of few people.
    """
    low, high = BODY_MASS_INDEX
    rows: list[int] = np.flatnonzero((index < low) | (index > high)).tolist()
    least, most = MEDIAN_INDEX
    if not rows and middle is not None and not least <= middle <= most:
        rows = np.argsort(np.abs(index - middle))[:1].tolist()
    return rows


def _mass_faults(table: _Table, column: str, mass: Floats, stature: Floats) -> Iterator[str]:
    """Report masses [kg] that are nobody's of such a stature [m]: a column in another unit."""
    index = mass / stature**2
    middle = float(np.median(index))
    rows = odd_masses(index, middle if len(index) >= _SEVERAL else None)
    low, high = BODY_MASS_INDEX
    unit = "tenths of a kilogram" if column == "weightkg" else "kilograms"
    for row in rows:
        yield (
            f"{table.path}:{table.lines[row]}: {column}: {mass[row]:g} kg is not the mass of a person "
            f"{1000 * stature[row]:g} mm tall (mass / stature^2 is {index[row]:.1f} kg/m^2, {low:g} to "
            f"{high:g} is a person's; the median of the file is {middle:.1f}): the column counts {unit}; "
            f"call it {MASS} where it holds kilograms, and convert pounds (0.4536 kg)"
        )


def _part_faults(
    table: _Table, columns_of: dict[str, tuple[str, ...]], values: dict[str, Floats]
) -> Iterator[str]:
    """Report measures [m] that are longer than what they are a part of, line by line."""
    wholes = dict(values)
    if {"stature", "sitting_height"} <= values.keys():
        wholes[_LEGS] = values["stature"] - values["sitting_height"]
    found = [
        (row, part, whole)
        for part, whole in _WHOLES.items()
        if part in values and whole in wholes
        for row in np.flatnonzero(values[part] >= wholes[whole]).tolist()
    ]
    for row, part, whole in sorted(found):
        yield (
            f"{table.path}:{table.lines[row]}: {columns_of[part][-1]}: the {plain(part)} is "
            f"{1000 * values[part][row]:g} mm where the {plain(whole)}, which it is a part of, is "
            f"{1000 * wholes[whole][row]:g} mm"
        )


def _unit(column: str, unit: float) -> float:
    """What 1 in a column is [m, kg]: two columns of the public files have units of their own."""
    if column == MASS:
        return 1.0
    return _UNITS.get(column, unit) if column == "weightkg" or unit == _MILLIMETRES else unit


def _sex(table: _Table, row: int, cell: str, faults: list[str]) -> int:
    name = cell.strip().lower()
    if name in SEXES:
        return SEXES.index(name)
    faults.append(f"{table.path}:{table.lines[row]}: {_SEX}: got {cell!r}; {one_of(name, SEXES)}")
    return 0


def _numbers(table: _Table, column: str, faults: list[str]) -> Floats:
    """(P,) the numbers of a column as recorded; NaN, and a fault, for what is no number."""
    values = np.full(len(table.lines), np.nan)
    for row, cell in enumerate(table.columns[column]):
        try:
            number = float(cell)
        except ValueError:
            number = math.nan
        if math.isfinite(number):
            values[row] = number
        else:
            faults.append(
                f"{table.path}:{table.lines[row]}: {column}: a number is needed (got {cell[:40]!r})"
            )
    return values


def _absurd(measure: str, values: Floats) -> Bools:
    """(P,) where a measure [m; kg for mass] is not that of a person."""
    low, high = MEASURES[measure]
    return ~((values >= low) & (values <= high))


def _absurd_words(
    table: _Table, row: int, measure: str, parts: tuple[str, ...], values: Floats
) -> str:
    """The fault of one absurd value of a measure that is made of these columns."""
    low, high = MEASURES[measure]
    unit, scale = ("kg", 1.0) if measure == MASS else ("mm", 1000.0)
    column = parts[0] if len(parts) == 1 else f"{parts[-1]} ({measure})"
    return (
        f"{table.path}:{table.lines[row]}: {column}: {values[row] * scale:g} {unit} is absurd for a "
        f"person; {low * scale:g} to {high * scale:g} {unit} is plausible"
    )


def _table(path: Path) -> _Table:
    """The cells of a CSV file; InputError where it is none, or a row has too many or few cells."""
    data = read_whole(path, "a CSV file", most=MOST_BYTES).removeprefix(BYTE_ORDER_MARK)
    if b"\0" in data:
        raise InputError(
            f"{path}: not text of one byte a letter (UTF-16?): save it as CSV in UTF-8"
        )
    text = printable(data.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n"))
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        words = [cell.strip().lower() for cell in next(reader, [])]
        stated = [_STATED.fullmatch(word) for word in words]
        if len(words) == 1 and (found := re.search("[;\t]", words[0])):
            raise InputError(f"{path}:1: columns are parted by {found[0]!r}: save it with commas")
        named = [found[1] if found else word for found, word in zip(stated, words, strict=True)]
        header = [_OWN.get(name, name).replace("_", "") for name in named]
        rows = [(reader.line_num, row) for row in reader if row]
    except csv.Error as error:
        raise InputError(f"{path}:{reader.line_num}: not a CSV file: {error}") from None
    if faults := list(_shape_faults(path, header, rows)):
        raise InputError(faults[:MOST_TOLD])
    columns = (list(column) for column in zip(*(row for _, row in rows), strict=True))
    units = {
        name: metres_in.get(found[2], 1.0)
        for name, found in zip(header, stated, strict=True)
        if found
    }
    return _Table(path, dict(zip(header, columns, strict=True)), [line for line, _ in rows], units)


def _shape_faults(
    path: Path, header: list[str], rows: list[tuple[int, list[str]]]
) -> Iterator[str]:
    """Report columns of one name, rows of another length than the header, and a file of nobody.

    rows: with their lines.
    """
    for name in dict.fromkeys(header):
        if header.count(name) > 1:
            yield f"{path}:1: column {name!r} stands twice"
    for line, row in rows:
        if len(row) != len(header):
            yield f"{path}:{line}: {len(header)} cells are needed, one a column (got {len(row)})"
    if not rows:
        yield f"{path}: holds no people"
