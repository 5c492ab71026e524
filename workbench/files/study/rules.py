"""Rule sets of sight and strain: the values of studies/rules/NAME.yaml in SI units and the workbench's axes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.catalogue import find
from workbench.files.schema import error_at, validate
from workbench.files.study.schema import RulesFile, RuleValueFile
from workbench.files.yaml_text import read_yaml
from workbench.model.rule_set import RuleSet, RuleValue
from workbench.model.units import plain

__all__ = ["load_rule_set", "rule_set"]

_UNITS = {
    "mm": 1e-3,
    "m": 1.0,
    "m2": 1.0,
    "deg": math.radians(1.0),
    "arcmin": math.radians(1.0) / 60.0,
    "in": 0.0254,
    "lb": 0.45359237,
    "kg": 1.0,
    "kgf": 9.80665,
    "N": 1.0,
    "h": 3600.0,
    "per min": 1.0 / 60.0,
    "per cm": 100.0,
    "per in": 1.0 / 0.0254,
    "per deg": math.degrees(1.0),
    "1": 1.0,
}
"""What one of each unit is in SI."""
_WORDS = {"deg": " degrees", "arcmin": " arc minutes", "in": " inches", "1": ""}
"""How units are written in a sentence that are not written as in a file."""
_AXES = {"forward left up": (1.0, 1.0, 1.0), "rearward right up": (-1.0, -1.0, 1.0)}
"""Signs that turn points of other axes to the workbench's."""


def load_rule_set(source: str | Path, *, near: Path | None = None) -> RuleSet:
    """Read the values of a rule set, by path or by its name in studies/rules.

    near: the folder of the file that names it. InputError lists all faults; a set that holds limits
    of injury alone, or rows of unequal length, is one.
    """
    document = read_yaml(find("studies/rules", str(source), near=near))
    file = validate(document, RulesFile)
    faults = [
        error_at(document, ("values", name, "value"), what)
        for name, value in file.values.items()
        if (what := _shape_fault(value))
    ]
    if not file.values:
        faults = [
            error_at(document, (), f"rule set {file.rules} has no 'values'; it limits injuries")
        ]
    if faults:
        raise InputError(faults)
    return RuleSet(
        file.rules,
        file.description,
        {name: _value(name, value) for name, value in file.values.items()},
        file.credit,
    )


def rule_set(given: RuleSet | str) -> RuleSet:
    """A rule set itself, or the one of a name or path as `load_rule_set` reads it."""
    return given if isinstance(given, RuleSet) else load_rule_set(given)


def _shape_fault(file: RuleValueFile) -> str:
    """What is wrong with the rows of a value, "" where nothing is."""
    if isinstance(file.value, list) and len({np.shape(row) for row in file.value}) != 1:
        return "a list of numbers is needed, or of rows that have the same length"
    if file.axes is not None and np.shape(file.value)[-1:] != (3,):
        return f"points in axes '{file.axes}' have three numbers each"
    return ""


def _value(name: str, file: RuleValueFile) -> RuleValue:
    signs = 1.0 if file.axes is None else np.array(_AXES[file.axes])
    value = np.asarray(np.array(file.value, dtype=np.float64) * _UNITS[file.unit] * signs)
    value.flags.writeable = False
    unit = _WORDS.get(file.unit, f" {file.unit}")
    axes = "" if file.axes is None else f" {file.axes}"
    figures = ", ".join(f"{figure:g}" for figure in np.ravel(file.value).tolist())
    figure = f" ({figures}{unit}{axes})" if value.ndim < 2 else ""
    called = f"{file.words or plain(name)}{figure}"
    return RuleValue(value, file.source, file.status, file.origin, file.doubt, called)
