"""Population: people as rows of measures. PopulationModel: what is needed to draw people like them.

The anthropometric measures are named as ANSUR II names them; definitions and landmarks: Hotzman et
al. 2011, NATICK/TR-11/017 (the measurer's handbook of ANSUR II). A name is the column of the public
ANSUR II files with its words set apart. Three differ: `mass` is `weightkg`, and
`acromial_height_sitting` and `cervicale_height_sitting` are derived: sitting height - (stature -
standing height).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arguments import check_index, checked, chosen_rows
from workbench.model.arrays import ArrayKind, Bools, Floats, Ints, freeze_fields

__all__ = [
    "COCKPIT",
    "GIRTHS",
    "MASS",
    "MEASURES",
    "ON_THE_BODY",
    "SEXES",
    "WORDS",
    "Population",
    "PopulationModel",
    "check_measures",
    "check_plausible",
    "sex_index",
]

MASS = "mass"
# The six of the boundary manikins of cockpits: Zehner, Meindl & Hudson 1993, AL-TR-1992-0164.
COCKPIT = (
    "thumb_tip_reach",
    "buttock_knee_length",
    "knee_height_sitting",
    "sitting_height",
    "eye_height_sitting",
    "acromial_height_sitting",
)
# Taken by a tape around the body.
GIRTHS = (
    "chest_circumference",
    "waist_circumference",
    "buttock_circumference",
    "thigh_circumference",
    "calf_circumference",
    "biceps_circumference_flexed",
)
# Those that the virtual anthropometer takes, and that a body can be scaled to.
ON_THE_BODY = (
    "stature",
    "acromial_height",
    "cervicale_height",
    "trochanterion_height",
    "lateral_femoral_epicondyle_height",
    "lateral_malleolus_height",
    "sitting_height",
    "eye_height_sitting",
    "acromial_height_sitting",
    "cervicale_height_sitting",
    "elbow_rest_height",
    "thigh_clearance",
    "knee_height_sitting",
    "popliteal_height",
    "buttock_knee_length",
    "buttock_popliteal_length",
    "abdominal_extension_depth_sitting",
    "hip_breadth_sitting",
    "hip_breadth",
    "bideltoid_breadth",
    "biacromial_breadth",
    "forearm_forearm_breadth",
    "shoulder_elbow_length",
    "acromion_radiale_length",
    "radiale_stylion_length",
    "forearm_hand_length",
    "forearm_center_of_grip_length",
    "hand_length",
    "hand_breadth",
    "thumb_tip_reach",
    "overhead_fingertip_reach_sitting",
    "foot_length",
    "foot_breadth_horizontal",
    "head_length",
    "head_breadth",
    "tragion_top_of_head",
    "interpupillary_breadth",
    "chest_depth",
    "waist_depth",
    "waist_breadth",
    "buttock_depth",
    *GIRTHS,
)
# (least, greatest) that a person may measure [m; kg for mass]: 0.45 times the least and 1.4 times
# the greatest of the 6068 people of ANSUR II (mass by hand), so that a child and a giant pass and a
# wrong unit does not.
MEASURES: dict[str, tuple[float, float]] = {
    "stature": (0.63, 2.8),
    "mass": (8, 250),
    "sitting_height": (0.34, 1.5),
    "eye_height_sitting": (0.29, 1.3),
    "acromial_height_sitting": (0.21, 1),
    "cervicale_height_sitting": (0.24, 1.1),
    "elbow_rest_height": (0.062, 0.48),
    "thigh_clearance": (0.054, 0.36),
    "knee_height_sitting": (0.18, 0.93),
    "popliteal_height": (0.14, 0.73),
    "buttock_knee_length": (0.21, 1),
    "buttock_popliteal_length": (0.17, 0.85),
    "abdominal_extension_depth_sitting": (0.07, 0.63),
    "hip_breadth_sitting": (0.13, 0.76),
    "bideltoid_breadth": (0.16, 0.89),
    "biacromial_breadth": (0.13, 0.68),
    "forearm_forearm_breadth": (0.17, 1.1),
    "shoulder_elbow_length": (0.12, 0.59),
    "acromion_radiale_length": (0.11, 0.55),
    "radiale_stylion_length": (0.076, 0.46),
    "forearm_hand_length": (0.15, 0.8),
    "forearm_center_of_grip_length": (0.12, 0.58),
    "hand_length": (0.065, 0.33),
    "hand_breadth": (0.03, 0.15),
    "thumb_tip_reach": (0.27, 1.4),
    "overhead_fingertip_reach_sitting": (0.5, 2.3),
    "span": (0.6, 3),
    "foot_length": (0.089, 0.45),
    "foot_breadth_horizontal": (0.035, 0.18),
    "head_length": (0.076, 0.32),
    "head_breadth": (0.059, 0.25),
    "tragion_top_of_head": (0.047, 0.21),
    "interpupillary_breadth": (0.023, 0.11),
    "menton_sellion_length": (0.041, 0.22),
    "bizygomatic_breadth": (0.052, 0.24),
    "trochanterion_height": (0.3, 1.5),
    "crotch_height": (0.27, 1.4),
    "lateral_femoral_epicondyle_height": (0.16, 0.83),
    "lateral_malleolus_height": (0.019, 0.13),
    "shoulder_length": (0.048, 0.26),
    "chest_breadth": (0.096, 0.51),
    "chest_depth": (0.076, 0.54),
    "waist_breadth": (0.095, 0.65),
    "waist_depth": (0.062, 0.57),
    "hip_breadth": (0.12, 0.66),
    "buttock_depth": (0.076, 0.49),
    "head_circumference": (0.23, 0.89),
    "neck_circumference": (0.12, 0.72),
    "chest_circumference": (0.31, 2.1),
    "waist_circumference": (0.27, 1.9),
    "buttock_circumference": (0.33, 1.9),
    "thigh_circumference": (0.19, 1.2),
    "calf_circumference": (0.12, 0.73),
    "ankle_circumference": (0.07, 0.41),
    "biceps_circumference_flexed": (0.097, 0.69),
    "forearm_circumference_flexed": (0.09, 0.56),
    "wrist_circumference": (0.056, 0.3),
}


# What people say for them.
WORDS: dict[str, str] = {
    "height": "stature",
    "body height": "stature",
    "tall": "stature",
    "weight": MASS,
    "body weight": MASS,
    "seated height": "sitting_height",
    "height sitting": "sitting_height",
    "eye height": "eye_height_sitting",
    "shoulder height": "acromial_height",
    "shoulder breadth": "bideltoid_breadth",
    "shoulder width": "bideltoid_breadth",
    "hip width": "hip_breadth",
    "waist width": "waist_breadth",
    "knee height": "knee_height_sitting",
    "thigh height": "thigh_clearance",
    "elbow height": "elbow_rest_height",
    "arm reach": "thumb_tip_reach",
    "reach": "thumb_tip_reach",
    "overhead reach": "overhead_fingertip_reach_sitting",
    "hip to knee": "buttock_knee_length",
    "upper arm length": "shoulder_elbow_length",
    "forearm length": "radiale_stylion_length",
    "hand width": "hand_breadth",
    "foot width": "foot_breadth_horizontal",
    "foot breadth": "foot_breadth_horizontal",
    "chest girth": "chest_circumference",
    "waist girth": "waist_circumference",
    "hip circumference": "buttock_circumference",
    "upper arm circumference": "biceps_circumference_flexed",
    "belly depth": "abdominal_extension_depth_sitting",
}


def check_measures(names: Iterable[str], known: Iterable[str] = MEASURES) -> tuple[str, ...]:
    """The names as a tuple; InputError for one that is not known or stands twice."""
    chosen = tuple(names)
    valid = tuple(known)
    faults = [
        f"no measure {name!r}; {one_of(name, valid, words=WORDS)}"
        for name in chosen
        if not isinstance(name, str) or name not in valid
    ]
    faults += [
        f"measure {name!r} is named twice"
        for name in dict.fromkeys(name for name in chosen if isinstance(name, str))
        if chosen.count(name) > 1
    ]
    if faults:
        raise InputError(faults)
    return chosen


def check_plausible(measures: Mapping[str, float]) -> None:
    """InputError for a measure [m; mass in kg] that nobody has: most likely a wrong unit."""
    faults = []
    for name, value in measures.items():
        low, high = MEASURES.get(name, (0.0, math.inf))
        if not (math.isfinite(value) and value > 0 and low <= value <= high):
            unit, factor = ("kg", 1.0) if name == MASS else ("mm", 1000.0)
            faults.append(
                f"{name} {factor * value:g} {unit} is not a person's ({factor * low:g} to {factor * high:g} "
                f"{unit} is): a wrong unit?"
            )
    if faults:
        raise InputError(faults)


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
