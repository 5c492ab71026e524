"""Single people in postures: each takes a place, then everything is measured and judged."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from workbench.body.forward import place, segment_frames
from workbench.body.pieces import piece_warnings
from workbench.contact.collide import body_contacts, contacts, self_contacts
from workbench.model.accommodation import OF_SIGHT
from workbench.model.arrays import Floats
from workbench.model.contacts import Clearance
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.model.joint_angles import join_poses
from workbench.model.poses import Poses
from workbench.model.result import (
    ControlReach,
    Finding,
    PersonFound,
    PosturesFound,
    Shortfall,
    Verdict,
)
from workbench.model.study import PredictedPosture, Role, Study
from workbench.model.workplace import Beside, Workplace
from workbench.posture.stops import stops
from workbench.study.checks import between_people, reach
from workbench.study.checks.table import findings_of, verdict
from workbench.study.envelope.envelope import envelopes
from workbench.study.hands import hands_together
from workbench.study.kept_reaches import kept_of_people, kept_words
from workbench.study.positions import (
    comfortable_situations,
    fitted_positions,
    in_positions,
)
from workbench.study.requirements import asked_of
from workbench.study.seat_words import move_words, setting_words, shortfalls, unjudged
from workbench.study.settings import at_setting
from workbench.study.situation import (
    Occupants,
    Situation,
    as_bystander,
    position_of,
)
from workbench.study.unasked import overlap_warnings, unasked_overlaps
from workbench.study.warnings import (
    controls_inside_solids,
    lost_seats,
    result_warnings,
    seat_verdicts,
)
from workbench.study.workplaces import drawn_number, occupant, workplace_of

__all__ = [
    "Present",
    "among_others",
    "people_found",
    "person_found",
    "present_people",
    "verdicts_of",
]


@dataclass(frozen=True, eq=False)
class Present:
    """People who are there at the same time.

    Parameters
    ----------
    environment
        With all their seats where they have put them.
    roles, situations
        Who they are; of each the cases, as they are checked.
    words
        What is improbable about their sizes, and where their seats are.
    short
        What their postures miss of what the cases ask of them.
    """

    environment: Environment
    roles: tuple[Role, ...]
    situations: tuple[tuple[Situation, ...], ...]
    words: tuple[str, ...]
    short: tuple[Shortfall, ...] = ()

    def beside(self) -> list[Beside]:
        """The people as somebody else finds them."""
        return [
            Beside(
                role.name,
                place(mine[0].body, poses_of(mine)),
                np.array([as_bystander(situation).solid for situation in mine]),
            )
            for role, mine in zip(self.roles, self.situations, strict=True)
        ]


def present_people(
    study: Study, occupants: Mapping[str, tuple[Occupants, list[str]]] | None = None
) -> Present:
    """Let the single people of a study take their places.

    Who stays where he or she is put comes first, then who chooses a position, by name: a later one
    heeds those before, whatever the order in the file. The hands go on their controls when
    everybody sits, clear of one another (`hands_together`), in the same order.

    Parameters
    ----------
    occupants
        By role, what `occupant` returns of it, where it is known already.
    """
    known = occupants or {}
    environment = study.environment
    rows = _in_turn(study)
    seated: dict[int, list[Situation]] = {}
    words: dict[int, list[str]] = {}
    for row in rows:
        role = study.roles[row]
        before = Present(
            environment,
            tuple(study.roles[one] for one in seated),
            tuple(map(tuple, seated.values())),
            (),
        )
        beside = before.beside() if _minds_others(study, role) else []
        number = drawn_number(study.roles, role)
        who, notes = known[role.name] if role.name in known else occupant(role, number)
        workplace = workplace_of(study, row, environment, beside)
        found, moves = _take_place(workplace, who, role)
        environment = found[0].environment_moved
        seated[row] = found
        words[row] = [*notes, *moves]
    by_case = [
        hands_together([situation.seat_moved(environment) for situation in case])
        for case in zip(*seated.values(), strict=True)
    ]
    done = dict(zip(rows, zip(*by_case, strict=True), strict=True))
    said = [line for row in sorted(rows) for line in words[row]]
    short = [line for row in sorted(rows) for one in done[row] for line in shortfalls(one)]
    return Present(
        environment,
        tuple(study.roles[row] for row in sorted(rows)),
        tuple(done[row] for row in sorted(rows)),
        tuple(said),
        tuple(unjudged(short, study.criteria)),
    )


def _in_turn(study: Study) -> list[int]:
    """The rows of the single people of a study in the order in which they take their places."""
    rows = [row for row, role in enumerate(study.roles) if role.population is None]
    names = [role.name for role in study.roles]
    return sorted(rows, key=lambda row: (_chooses(study, row), names[row]))


def _chooses(study: Study, row: int) -> bool:
    """Whether a role has a seat, or an area to step in, whose position is to be found."""
    role = study.roles[row]
    predicted = any(isinstance(case.actions[row], PredictedPosture) for case in study.postures)
    return role.free and (predicted or role.seat is None)


def _minds_others(study: Study, role: Role) -> bool:
    """Whether a role is to keep apart from others, or may have them before the eyes."""
    return any(
        criterion.check in ("between_people", *OF_SIGHT) and role.name in criterion.people
        for criterion in study.criteria
    )


def _take_place(
    workplace: Workplace, who: Occupants, role: Role
) -> tuple[list[Situation], list[str]]:
    """One person in the position and setting that meet all that is asked, nearest to the
    comfortable and the nominal one; and in words that these are others."""
    comfortable = comfortable_situations(workplace, who)
    asked = asked_of(workplace)
    first = workplace.first_predicted
    given = workplace.cases[first].aims is None and workplace.seat is not None
    if not role.free or given or not asked:
        return comfortable, []
    no_sets = np.zeros((len(asked), 0), dtype=np.bool_)
    found = fitted_positions(workplace, asked, no_sets, who, comfortable)
    there = at_setting(workplace, found.setting[0])
    if there is not workplace:
        comfortable = comfortable_situations(there, who)
    words = move_words(comfortable[first], found, asked)
    words = [*setting_words(comfortable[first], workplace, found, asked), *words]
    if not words:
        return comfortable, []
    return in_positions(there, who, found.tried.seat, comfortable), words


def poses_of(situations: Sequence[Situation]) -> Poses:
    """(P,) the poses of one person in all cases."""
    reference = situations[0].poses.reference
    found = []
    for situation in situations:
        poses = situation.poses
        if poses.reference != reference:
            world = segment_frames(situation.body, poses, reference)
            poses = Poses(poses.rotations, reference, world)
        found.append(poses)
    return join_poses(found)


def people_found(study: Study, there: Present) -> PosturesFound:
    """Find how the single people of a study, who are there, come out in its postures."""
    environment = there.environment
    people = tuple(
        person_found(role, mine) for role, mine in zip(there.roles, there.situations, strict=True)
    )
    reaches = tuple(
        row
        for mine in there.situations
        for situation in mine
        for row in reach.control_reaches(situation)
    )
    cases = tuple(case.name for case in study.postures)
    placed = {person.name: person.placed for person in people}
    between = {
        (one, other): body_contacts(placed[one], placed[other])
        for one, other in combinations(placed, 2)
    }
    overlaps = unasked_overlaps(study.criteria, cases, people, between)
    return PosturesFound(
        study=study,
        cases=cases,
        environment=environment,
        verdicts=(
            *seat_verdicts(environment, cases, people),
            *verdicts_of(study.criteria, there, reaches, cases),
        ),
        people=people,
        between=between,
        warnings=(
            *kept_words(kept_of_people(environment, study.criteria, reaches)),
            *there.words,
            *(one.sentence for one in there.short),
            *piece_warnings((person.name, person.body) for person in people),
            *(controls_inside_solids(environment) if reaches else ()),
            *result_warnings(
                environment, cases, people, lost_seats(study.environment, there.roles)
            ),
            *overlap_warnings(overlaps),
        ),
        short=there.short,
        reaches=reaches,
        envelopes=tuple(envelopes(study, there.situations)),
    )


def person_found(role: Role, situations: Sequence[Situation]) -> PersonFound:
    """Measure one person in the situations (C,) of all cases."""
    poses = poses_of(situations)
    placed = place(situations[0].body, poses)
    margins = stops(placed.body, poses)
    joints = range(len(placed.body.joints))
    ahead, other = position_of(situations[0])[0].tolist()
    return PersonFound(
        role=role,
        poses=poses,
        placed=placed,
        postures=tuple(_posture(situation) for situation in situations),
        forward=ahead,
        up=other,
        contacts=contacts(placed, situations[0].environment),
        self_contacts=self_contacts(placed),
        clearance=_joined([situation.nearest for situation in situations]),
        margin=margins.margin,
        margin_motion=tuple(
            tuple(margins.motion(case, joint) for joint in joints) for case in range(len(placed))
        ),
    )


def _posture(situation: Situation) -> str:
    """What the posture of a case is called."""
    aims = situation.work.aims
    if aims is None:
        return situation.work.posture
    return "predicted" if aims.driving is None else "driver"


def _joined(parts: Sequence[Clearance]) -> Clearance:
    """The clearances of several poses of one body."""

    def whole(name: str) -> Floats:
        return np.concatenate([getattr(part, name) for part in parts])

    first = parts[0]
    return Clearance(
        body=first.body,
        other=first.other,
        distance=whole("distance"),
        sphere=np.concatenate([part.sphere for part in parts]),
        target=np.concatenate([part.target for part in parts]),
        point=whole("point"),
        facing=np.concatenate([part.facing for part in parts]),
    )


def verdicts_of(
    criteria: Sequence[Criterion],
    there: Present,
    reaches: Sequence[ControlReach],
    cases: tuple[str, ...],
) -> Iterator[Verdict]:
    """Judge criteria that are asked of single people in postures.

    Parameters
    ----------
    criteria
        Those that nobody is asked about are passed over.
    reaches
        What the people reach in these cases.
    cases
        The names of the cases that `there` has, in their order.
    """
    names = {role.name for role in there.roles}
    alone = [situation for mine in there.situations for situation in mine]
    seeing = among_others(there) if any(one.check in OF_SIGHT for one in criteria) else []
    for criterion in criteria:
        people = names.intersection(criterion.people)
        enough = len(names) > 1 if criterion.check == "between_people" else True
        asked = bool(people) and enough and any(criterion.asks(case) for case in cases)
        if not asked or criterion.check in ("share", "injury"):
            continue
        if criterion.check == "reach":
            mine = reach.findings(reaches, criterion)
            found = [finding for finding in mine if criterion.asks(finding.case)]
        elif criterion.check == "between_people":
            found = list(_between(criterion, there))
        else:
            found = findings_of(seeing if criterion.check in OF_SIGHT else alone, criterion)
        yield verdict(criterion, found, cases)


def _between(criterion: Criterion, there: Present) -> Iterator[Finding]:
    """What a criterion finds between each two people, case by case."""
    for one, other in combinations(there.situations, 2):
        if {one[0].place.role, other[0].place.role}.intersection(criterion.people):
            for mine, yours in zip(one, other, strict=True):
                if criterion.asks(mine.work.name):
                    yield from between_people.findings(mine, yours, criterion)


def among_others(there: Present) -> list[Situation]:
    """Everybody in every case, with the others as they are there: what may stand before the eyes is
    collected once for all criteria."""
    return [
        replace(one, bystanders=tuple(as_bystander(other) for other in case if other is not one))
        for case in zip(*there.situations, strict=True)
        for one in case
    ]
