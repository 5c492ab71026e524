"""The dimension that leaves somebody out: of the measures that bear on what is missed, the one that
is oddest.

Odd is how far a measure stands, in the direction that hurts, from what the person's other bearing
measures make likely in people of that sex (in standard deviations; see people.conditional).
Somebody small all over has no odd measure; then it is the one that stands farthest in that
direction by itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.body.people.conditional import Scores, mahalanobis_distance, scores_of
from workbench.errors import InputError
from workbench.files.populations import load_population_model
from workbench.model.accommodation import OF_SIGHT
from workbench.model.arrays import Ints
from workbench.model.body import Body
from workbench.model.criterion import Reason
from workbench.model.population import COCKPIT, MASS, SEXES, Population
from workbench.model.study import Study
from workbench.study.checks.margins import Asked
from workbench.study.checks.seat_travel import SEAT_FORWARD
from workbench.study.checks.view import TOO_HIGH
from workbench.study.persons import role_body

__all__ = ["BEARING", "doubted_people", "limiting_measures", "odd_people", "relevant_measures"]

ENOUGH = 100
"""People of a sex from which on their own spread is that of a population; fewer are compared with
ANSUR II."""
PLAIN = 1.0
"""Standard deviations below which a measure is not odd."""
ODD = 7.0
"""Standard deviations of a measure from what the others make likely that nobody has: of the 6068
people of ANSUR II the greatest is 5.5."""
NAMED = 5
"""People at most that are named as odd."""
BEARING: dict[str, tuple[str, ...]] = {
    "hand": (
        "thumb_tip_reach",
        "acromial_height_sitting",
        "biacromial_breadth",
        "shoulder_elbow_length",
        "forearm_hand_length",
        "hand_length",
    ),
    "foot": ("buttock_knee_length", "popliteal_height", "knee_height_sitting", "foot_length"),
    "eyes": ("eye_height_sitting", "acromial_height_sitting"),
    "H": ("sitting_height", "head_length", "head_breadth"),
    "N": ("sitting_height", "acromial_height_sitting"),
    "trunk": (
        "abdominal_extension_depth_sitting",
        "chest_depth",
        "waist_breadth",
        "acromial_height_sitting",
    ),
    "pelvis": ("hip_breadth_sitting", "abdominal_extension_depth_sitting", "thigh_clearance"),
    "shoulder": ("bideltoid_breadth", "biacromial_breadth", "acromial_height_sitting"),
    "arm": (
        "forearm_forearm_breadth",
        "bideltoid_breadth",
        "elbow_rest_height",
        "shoulder_elbow_length",
        "forearm_hand_length",
    ),
    "thigh": ("thigh_clearance", "buttock_knee_length", "knee_height_sitting"),
    "shin": ("knee_height_sitting", "buttock_knee_length", "popliteal_height"),
    "shoe": ("foot_length", "foot_breadth_horizontal", "popliteal_height"),
}
"""The measures that bear on a limb's reach, on the eyes, and on what a segment touches."""
STANDING = {
    "sitting_height": "stature",
    "eye_height_sitting": "stature",
    "acromial_height_sitting": "acromial_height",
    "elbow_rest_height": "acromial_height",
    "hand_length": "stature",
    "abdominal_extension_depth_sitting": "waist_depth",
    "hip_breadth_sitting": "hip_breadth",
    "thigh_clearance": "buttock_depth",
    "buttock_knee_length": "trochanterion_height",
    "knee_height_sitting": "lateral_femoral_epicondyle_height",
    "popliteal_height": "lateral_femoral_epicondyle_height",
}
"""What bears on people who stand in place of what is measured of those who sit; in place of a hand's
length, which leans and steps make up for, the stature."""
_SEGMENTS = {
    "H": "H",
    "N": "N",
    "UT": "trunk",
    "CT": "trunk",
    "LT": "pelvis",
    "SM": "shoulder",
    "UA": "arm",
    "LA": "arm",
    "HN": "arm",
    "UL": "thigh",
    "LL": "shin",
    "F": "shoe",
}


def relevant_measures(
    one: Asked, reason: Reason, body: Body, *, sits: bool = True
) -> tuple[tuple[str, ...], int]:
    """The measures that bear on a requirement and the direction in which they hurt (-1: too small,
    1: too large).

    reason: what limits, as of `Margins`; sits: whether people sit.
    """
    names, sign = _bearing_on(one, reason, body)
    if sits:
        return names, sign
    return tuple(dict.fromkeys(STANDING.get(name, name) for name in names)), sign


def _bearing_on(one: Asked, reason: Reason, body: Body) -> tuple[tuple[str, ...], int]:
    """The same of people who sit."""
    check = one.requirement.check
    if check in ("reach", "pedals") and reason.kind in ("part", "deep", "own", "other"):
        return (), 1  # what is in the way is in nobody's measures
    if check in ("pedals", "preferred_seat"):
        return BEARING["foot"], 1 if reason == SEAT_FORWARD else -1
    if check == "reach":
        by_foot = one.control is not None and one.control.for_feet
        return BEARING["foot" if by_foot else "hand"], -1
    if check in ("eye_height", "view_over", "over_nose"):
        return BEARING["eyes"], 1 if reason == TOO_HIGH else -1
    if check in ("stops", "self_contact", "excursion", "score", "force", *OF_SIGHT):
        return (), 1
    named = [n for n, name in enumerate(body.segment_names) if reason.thing.startswith(name)]
    segment = body.segments[max(named, key=lambda n: len(body.segment_names[n]))] if named else ""
    return BEARING[_SEGMENTS.get(segment) or _SEGMENTS.get(segment[1:], "trunk")], 1


def limiting_measures(
    people: Population, rows: Ints, bearing: Sequence[tuple[tuple[str, ...], int]]
) -> list[str]:
    """The limiting measure of each of some people (rows), of those that bear on what they miss; ""
    where none is known."""
    found = [""] * len(rows)
    for sex in np.unique(people.sex[rows]):
        scores = _scores(people, SEXES[int(sex)])
        for names, sign in dict.fromkeys(bearing):
            known = [name for name in names if name in people.names and name in scores.names]
            some = [
                k
                for k, row in enumerate(rows)
                if bearing[k] == (names, sign) and people.sex[row] == sex
            ]
            if some and known:
                for k, best in zip(
                    some, _oddest(scores, people.rows(rows[some]), known, sign), strict=True
                ):
                    found[k] = known[int(best)]
    return found


def doubted_people(study: Study) -> list[str]:
    """Say what a run of a study says of who its people are: of sizes that hardly anybody has, and of
    rows of a population."""
    notes = dict.fromkeys(
        note
        for _, one in study.by_size()
        for role in one.roles
        if role.size is not None
        for note in role_body(role)[1]
    )
    crowd = study.crowd
    rows = (
        odd_people(crowd.population) if crowd and isinstance(crowd.population, Population) else []
    )
    return [*notes, *rows]


def odd_people(people: Population) -> list[str]:
    """Warn of people with a measure that nobody like them has: slips of the tape, or a wrong unit.

    Each of the measures that a workplace is fitted to, stature and mass is judged against the
    person's others, by the adults of ANSUR II.
    """
    model = load_population_model("ansur2", people=False)
    names = [name for name in (*COCKPIT, "stature", MASS) if name in people.names]
    words: list[str] = []
    for sex in np.unique(people.sex).tolist() if len(names) > 1 else ():
        rows = np.flatnonzero(people.sex == sex)
        given = {name: people.column(name)[rows] for name in names}
        surprise = mahalanobis_distance(scores_of(model, SEXES[sex]), given).surprise
        for k in np.flatnonzero(np.abs(surprise).max(axis=1) > ODD).tolist():
            name = names[int(np.abs(surprise[k]).argmax())]
            value = given[name][k] if name == MASS else 1000 * given[name][k]
            unit = "kg" if name == MASS else "mm"
            words.append(f"{people.called(rows[k])} ({name} {value:.4g} {unit})")
    if not words:
        return []
    more = f" and {len(words) - NAMED} more" if len(words) > NAMED else ""
    return [
        f"{len(words)} of {len(people)} people have a measure more than {ODD:g} standard deviations from what "
        "their other measures make likely in adults: a slip, or another unit? "
        f"{', '.join(words[:NAMED])}{more}"
    ]


def _oddest(scores: Scores, people: Population, names: Sequence[str], sign: int) -> Ints:
    """(P,) the measure that is oddest in a direction given the others; by itself for people in whom
    none is."""
    found = mahalanobis_distance(scores, {name: people.column(name) for name in names})
    surprise = sign * found.surprise
    alone = sign * found.z
    plain = surprise.max(axis=1) < PLAIN
    best: Ints = np.where(plain, alone.argmax(axis=1), surprise.argmax(axis=1))
    return best


def _scores(people: Population, sex: str) -> Scores:
    own = people.of_sex(sex)
    if len(own) >= ENOUGH:
        try:
            return scores_of(people, sex)
        except InputError:  # a measure that is the same for everybody
            pass
    return scores_of(load_population_model("ansur2", people=False), sex)
