"""Population: people as rows of measures. PopulationModel: what is needed to draw people like
them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arguments import check_index, checked, chosen_rows
from workbench.model.arrays import ArrayKind, Bools, Floats, Ints, freeze_fields
from workbench.model.measures import check_measures

__all__ = ["SEXES", "Population", "PopulationModel", "sex_index"]

SEXES = ("male", "female")


def sex_index(sex: str, sexes: tuple[str, ...] = SEXES) -> int:
    """Index of a sex by its name; InputError lists the valid ones."""
    if not isinstance(sex, str) or sex not in sexes:
        raise InputError(f"no sex {sex!r} here; {one_of(sex, sexes)}")
    return sexes.index(sex)


def person_name(label: str) -> str:
    """What somebody is called in a sentence: "female 31", "person 31" of a mere number."""
    return f"person {label}" if label.isdecimal() else label


@dataclass(frozen=True, eq=False, repr=False)
class Population:
    """P people and M measures of each.

    names (M): the measures; sex (P,): index into SEXES; weight (P,): in the sample, positive;
    measures (P, M) [m; kg for mass]: positive; source: where they come from; labels (P): what each
    person is called, or () where nobody is.
    """

    names: tuple[str, ...]
    sex: Ints
    weight: Floats
    measures: Floats
    source: str
    labels: tuple[str, ...] = ()

    def called(self, row: int) -> str:
        """What one of the people is called: "female 31", "person 31" where there are no labels."""
        row = check_index("row", row, len(self))
        return person_name(self.labels[row] if self.labels else str(row + 1))

    def __repr__(self) -> str:
        men = int((self.sex == 0).sum())
        return f"Population({self.source}: {men} men, {len(self) - men} women, {len(self.names)} measures)"

    def __post_init__(self) -> None:
        people = len(self.sex)
        arrays: dict[str, ArrayKind] = {
            "sex": (np.int64, (people,)),
            "weight": (np.float64, (people,)),
            "measures": (np.float64, (people, len(self.names))),
        }
        freeze_fields(self, arrays, "population")
        check_measures(self.names)
        if fault := self._fault():
            raise InputError(f"population {self.source}: {fault}")

    def _fault(self) -> str:
        """What is wrong with the people; "" where nothing is."""
        if not np.all(np.isin(self.sex, range(len(SEXES)))):
            return f"a sex is an index into {', '.join(SEXES)}"
        if not np.all((self.weight > 0) & np.isfinite(self.weight)):
            return "every weight must be positive and finite"
        bad = np.argwhere(~((self.measures > 0) & np.isfinite(self.measures)))
        if len(bad):
            row, column = bad[0]
            got = self.measures[row, column]
            return f"person {row}: {self.names[column]}: must be positive, got {got}"
        if len(self.labels) not in (0, len(self.sex)):
            return f"{len(self.labels)} labels for {len(self.sex)} people"
        return ""

    def __len__(self) -> int:
        return len(self.sex)

    def column(self, name: str) -> Floats:
        """(P,) one measure [m; kg for mass]; InputError lists the valid ones."""
        check_measures([name], self.names)
        return np.asarray(self.measures[:, self.names.index(name)])

    @checked
    def of(self, names: Iterable[str]) -> Population:
        """The same people with these measures only, in this order."""
        chosen = check_measures(names, self.names)
        return replace(
            self,
            names=chosen,
            measures=self.measures[:, [self.names.index(name) for name in chosen]],
        )

    def rows(self, keep: Bools | Ints) -> Population:
        """The people at a mask or at indices."""
        index = np.arange(len(self))[chosen_rows("keep", keep, len(self))]
        labels = tuple(self.labels[i] for i in index) if self.labels else ()
        measures = self.measures[index]
        return replace(
            self, sex=self.sex[index], weight=self.weight[index], measures=measures, labels=labels
        )

    def count(self, sex: str) -> int:
        """Number of people of one sex."""
        return int(np.sum(self.sex == sex_index(sex)))

    @checked
    def lacking(self, men: int, women: int) -> str:
        """Say which people are fewer than are wanted; "" where there are enough."""
        wanted = {"male": men, "female": women}
        words = {"male": "men", "female": "women"}
        short = [
            f"{self.count(sex)} {words[sex]} ({number} are asked for)"
            for sex, number in wanted.items()
            if self.count(sex) < number
        ]
        return f"{self.source} has {' and '.join(short)}" if short else ""

    def of_sex(self, sex: str) -> Population:
        """The people of one sex; InputError where there is none."""
        keep = self.sex == sex_index(sex)
        if not keep.any():
            raise InputError(f"population {self.source}: nobody in it is {sex}")
        return self.rows(keep)


@dataclass(frozen=True, eq=False, repr=False)
class PopulationModel:
    """X sexes, M measures: a quantile table each, and how they go together (a Gaussian copula).

    sexes (X): of SEXES; count (X,): people measured; levels (Q,): shares of the people, 0 to 1;
    quantiles (X, M, Q) [m; kg for mass]: rising; at the levels 0 and 1 stand the least and the
    greatest person; correlation (X, M, M): of the normal scores, symmetric and positive definite;
    people: the measured people themselves with the same measures, None where the figures are all
    that is known.
    """

    name: str
    description: str
    source: str
    names: tuple[str, ...]
    sexes: tuple[str, ...]
    count: Ints
    levels: Floats
    quantiles: Floats
    correlation: Floats
    people: Population | None = None

    def __repr__(self) -> str:
        people = ", ".join(
            f"{n} {sex}" for sex, n in zip(self.sexes, self.count.tolist(), strict=True)
        )
        return f"PopulationModel({self.name}: {people}, {len(self.names)} measures)"

    def __post_init__(self) -> None:
        x = len(self.sexes)
        m = len(self.names)
        q = len(self.levels)
        arrays: dict[str, ArrayKind] = {
            "count": (np.int64, (x,)),
            "levels": (np.float64, (q,)),
            "quantiles": (np.float64, (x, m, q)),
            "correlation": (np.float64, (x, m, m)),
        }
        freeze_fields(self, arrays, "model")
        check_measures(self.names)
        self._check()

    def _check(self) -> None:
        faults = (self._sex_fault, self._level_fault, self._matrix_fault, self._people_fault)
        if fault := next((words for find in faults if (words := find())), ""):
            raise InputError(f"population {self.name}: {fault}")

    def _sex_fault(self) -> str:
        """What is wrong with the sexes; "" where nothing is."""
        different = set(self.sexes)
        if not self.sexes or len(different) < len(self.sexes) or not different <= set(SEXES):
            return f"one or both of {', '.join(SEXES)} are needed, got {self.sexes}"
        return ""

    def _level_fault(self) -> str:
        """What is wrong with the levels and the quantiles; "" where nothing is."""
        ends = len(self.levels) > 2 and self.levels[0] == 0 and self.levels[-1] == 1
        if not ends or not np.all(np.diff(self.levels) > 0):
            return "levels must rise from 0 to 1 over three or more"
        inner = min(self.levels[1], 1 - self.levels[-2])
        if not np.all(0.5 / self.count < inner):
            least = int(0.5 / inner) + 1
            few = f"{self.count.min()} people are too few for the level {inner:g}"
            return f"{few}; {least} are needed"
        if not np.all(np.isfinite(self.quantiles)) or not np.all(np.diff(self.quantiles) > 0):
            return "quantiles must be finite and rise"
        return ""

    def _matrix_fault(self) -> str:
        """What is wrong with the correlations; "" where nothing is."""
        turned = np.swapaxes(self.correlation, 1, 2)
        unit = np.diagonal(self.correlation, axis1=1, axis2=2)
        if not np.array_equal(self.correlation, turned) or not np.all(unit == 1):
            return "a correlation matrix is symmetric, with ones on its diagonal"
        if not np.all(np.linalg.eigvalsh(self.correlation) > 0):
            return "a correlation matrix has positive eigenvalues only"
        return ""

    def _people_fault(self) -> str:
        """What is wrong with the measured people; "" where nothing is."""
        if self.people is None:
            return ""
        if self.people.names != self.names:
            return "its people need the same measures in the same order"
        for sex, count in zip(self.sexes, self.count.tolist(), strict=True):
            found = self.people.count(sex)
            if found != count:
                return f"{count} {sex} people are counted, and {found} are there"
        if len(self.people) != self.count.sum():
            return f"it has people who are not {' or '.join(self.sexes)}"
        return ""
