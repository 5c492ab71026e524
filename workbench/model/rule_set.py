"""Rule set: the numbers of a published rule, each with its source and how sure it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats, read_only

__all__ = ["CHOSEN", "REMEMBERED", "RuleSet", "RuleValue"]

REMEMBERED = "from memory, not checked against the rule's text"
"""What is said of a value whose source was not at hand."""
CHOSEN = "chosen here, the rule gives no number"
"""What is said of a value that a rule needs and leaves open."""


@dataclass(frozen=True, eq=False)
class RuleValue:
    """A number or an array of numbers in SI units, in the workbench's axes where it is of points.

    source: where it was seen, or what is known of it; status: "seen" where it was read there,
    "remembered" where that was not at hand, "chosen" where the rule leaves it open. origin: of a
    field on the ground, from what it counts behind ("eyes" or "front" of the vehicle), and out
    ("side", "middle" or "eyes"). doubt: what was settled without the source, "" of nothing. called:
    what it is in a sentence, with its figure and unit where that is one number or a few.
    """

    value: Floats
    source: str
    status: str
    origin: tuple[str, str] | None = None
    doubt: str = ""
    called: str = ""

    @property
    def words(self) -> str:
        """How sure it is."""
        doubt = f", {self.doubt}" if self.doubt else ""
        if self.status == "seen":
            return f"seen in {self.source}{doubt}"
        return f"{CHOSEN if self.status == 'chosen' else REMEMBERED} ({self.source}{doubt})"


@dataclass(frozen=True, eq=False)
class RuleSet:
    """A named set of values. `rules["v1"]` is an array, `rules.number("limit")` one number.

    A figure that is made with values carries `status` of their names to whatever prints it, and
    with it `credit`, the words that the licence of the values asks for.
    """

    name: str
    description: str
    values: dict[str, RuleValue]
    credit: str = ""

    def __getitem__(self, name: str) -> Floats:
        return self._found(name).value

    def shaped(self, name: str, *shape: int | None) -> Floats:
        """A value that is an array of a shape, None for any length; InputError for another, and for
        a name that there is not."""
        return read_only(self[name], np.float64, shape, f"rule set {self.name}: {name}")

    def number(self, name: str) -> float:
        """A value that is one number; InputError as of `shaped`."""
        return float(self.shaped(name))

    def status(self, *names: str) -> str:
        """Say where values are from: each source once, after the names that it holds for."""
        by_words: dict[str, list[str]] = {}
        for name in names:
            by_words.setdefault(self._found(name).words, []).append(name)
        told = [f"{', '.join(group)}: {words}" for words, group in by_words.items()]
        return f"{self.name}: " + "; ".join(told + [self.credit] * bool(self.credit))

    def told(self, *names: str) -> str:
        """Name the rule set for a sentence, with which of some values are not sure, and their doubts."""
        values = [self._found(name) for name in names]
        unsure = [value.called for value in values if value.status == "remembered"]
        told = [self.description, *([f"{', '.join(unsure)}: {REMEMBERED}"] if unsure else [])]
        told += [f"{value.called}: {value.doubt}" for value in values if value.doubt]
        return "; ".join(told)

    @property
    def sure(self) -> bool:
        """Whether all values were seen in their sources."""
        return all(value.status == "seen" for value in self.values.values())

    @property
    def all_told(self) -> str:
        """Name the rule set for a sentence, with which of its values are not sure: their names, or
        how many where they are more than two; how many were chosen; and the credit."""
        credit = f"; {self.credit}" if self.credit else ""
        unsure = sum(value.status == "remembered" for value in self.values.values())
        chosen = sum(value.status == "chosen" for value in self.values.values())
        of = f"{chosen} of its {len(self.values)} values {'is' if chosen == 1 else 'are'}"
        last = (f"; {of} {CHOSEN}" if chosen else "") + credit
        if unsure <= 2:
            return self.told(*self.values) + last
        return (
            f"{self.description}; {unsure} of its {len(self.values)} values are {REMEMBERED}{last}"
        )

    def _found(self, name: str) -> RuleValue:
        if name not in self.values:
            hint = one_of(name, self.values)
            raise InputError(f"rule set {self.name}: no value {name!r}; {hint}")
        return self.values[name]
