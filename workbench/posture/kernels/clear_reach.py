"""Reaches kept clear of obstacles, by one search: the tip on its target, the joints within their
stops and the spheres out of all parts, at once, and comfort afterwards.

Let e(q) [m] be the distance of the tip from its target at joint angles q, s_r(q) [rad] the room to
stop r, and d_i(q) [m] how far contact i is apart beyond what is allowed. A reach is any q with

    e(q) = 0,   s_r(q) >= 0 for all r,   d_i(q) >= 0 for all i.

Where there is one, what is left is zero there, so damped Gauss-Newton steps on the sum of squares
of what is violated find it (Nocedal & Wright 2006, Numerical Optimization, chapter 10). The contacts
are exact and found anew at each step; none is kept, since a sphere that moves on meets others. The
search begins at the posture that reaches the target but for obstacles, then at postures of all
kinds. What comes clear is made comfortable among all that is near it.

Who does not reach a target is brought as near to it as is found: the same steps bring the tip to
within a radius of the target, which is doubled until that is found and then halved down.

A row that a search has found no reach for, its person sitting elsewhere, is not searched for whole
again: the postures known from there are tried, and few starts (`FEW_STARTS`).

How near that is depends on the start. A miss that is to be told is asked again from many
(`_come_nearer`), each of which must beat the best so far.

A search is no proof. Where the target is too deep in a solid for any posture there is one, and
nothing is searched (`_buried_in`). Such a row is brought near from few starts.

A row knows of no other row.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.contact.kernels.distance_field import penetration_depth, square_bound
from workbench.geometry.vectors import (
    rotation_part,
    store,
    subtract,
    transpose_matvec,
    vector,
)
from workbench.posture.kernels.augmented_lagrangian import (
    DISTANT_EASE,
    REACHED,
    discomfort,
    evaluate,
    minimize,
    minimize_distance,
    put_row,
    take,
    take_row,
)
from workbench.posture.kernels.chain_kinematics import ChainState, Linkage, new_state
from workbench.posture.kernels.hand_room import (
    SURELY,
    ProofWorkspace,
    has_no_room,
    most_allowed,
    new_turns,
)
from workbench.posture.kernels.inequality_constraints import ContactPlanes, clamp_angles
from workbench.posture.kernels.inverse_kinematics import (
    LEGAL,
    NEARLY,
    next_seed,
    place_seeds,
    residual,
)
from workbench.posture.kernels.limb_contacts import (
    Limbs,
    Obstacles,
    Space,
    find_contacts,
    forget,
    new_space,
    plane_of_contact,
    way_of_people,
)
from workbench.posture.kernels.newton_step import (
    DescentWorkspace,
    new_work,
    newton,
    normal_equations,
    take_step,
)

__all__ = [
    "BRIEF",
    "BURIED",
    "FEW_STARTS",
    "HOPELESS",
    "KEPT",
    "KNOWN_POSTURES",
    "NEARER",
    "NEXT_TO",
    "NO_ROOM",
    "PRECISE",
    "SKIPPED",
    "WHOLE",
    "Looked",
    "Outcome",
    "clear_reaches",
    "new_desk",
    "prove_no_room",
    "still_reaches",
]

CLEAR = 2e-4
"""How far [m] beyond what is allowed a posture is kept off obstacles, so that rounding does not
touch them."""
HINT = 2e-3
NEAR = 0.03
"""How near [m] parts are minded: where a posture is sought, and where it is made comfortable."""
PLANE_GRID = 2.0**20
"""[1/m] Planes of contacts are rounded to one over this, a micrometre, in the axes of the segment that
the limb hangs on: the last digits, which are others once a cockpit is turned, choose no step."""
MOST_PLANES = 16
ALIKE = 0.95
"""Cosine between the normals of two contacts of one sphere above which only the deeper counts."""
MOST_STEPS = 60
MOST_SLOW = 14
BETTER = 0.97
"""Steps of an attempt; those in a row that leave more than so much of what is violated."""
PULL = 1e4
EASE = 1e-4
DAMPING = 1.0
"""Weights of a step: of the tip [1/m2], of comfort [1/rad2] and of its length [1/rad2]."""
ARRIVED = 5e-5
INSIDE = 2e-4
"""Distance [m] and breach [rad] with which an attempt has arrived."""
RADIAN = 0.3
"""What a radian past a stop counts [m]."""
LOTS = (4, 12, 24, 40, 48)
FEW_LOTS = 2
LOTS_OF_BURIED = 1
LOTS_OF_FEW_STARTS = 1
LOTS_BEFORE_PROOF = 2
"""How many starts a search takes from the seeds, one lot after the other; how many lots where the
limb enters nothing and is only short of the target, where the target is buried, of FEW_STARTS, and
before a proof is sought that the hand has no room."""
POOL = 8
KICKS = 160
KICK = (0.1, 0.25, 0.5, 0.75)
"""Starts about the best that failed: of how many of these, how many starts, and how far they go
toward other postures."""
FIRST_KICKS = 40
HOPELESS = 0.03
"""After so many of them [m] what the best may leave violated for more to be tried."""
CLOSE = 0.01
OFF = 0.05
"""Distance [m] and breach [rad] within which a start reaches the target, obstacles aside."""
TOWARD = 24
"""Steps of a start toward the target."""
FOLLOWING_STEPS = 4
"""Steps of a reach that is looked at again toward the target, obstacles aside."""
EASY_TURNS = 3
EASY_STEPS = 24
GAIN = 0.98
"""Turns and steps in which a clear posture is made comfortable; the share of the discomfort above
which no further turn is worth it."""
FIRST_RADIUS = 1e-3
WIDENING = 3.0
MOST_RADII = 7
NARROWING = 5
"""By how much [m] a target may be missed at first, how much more each time, how often, and how often
that is halved."""
NEARER_KICKS = 32
NEARER_SEEDS = 96
"""Starts about the best posture, and starts from seeds, as they are or brought to the target in
turns, that a miss is asked again from."""
BOLD = 0.3
TIMID = 0.9
"""What is left of a miss that is to be beaten, at the first try of a start and at the second."""
PRECISE = 2e-4
MOST_HALVINGS = 12
"""How precise [m] a miss is that is asked again, and how often a radius is halved for it at most."""

WHOLE = 0
FEW_STARTS = 1
BRIEF = 2
NO_ROOM = 3
SKIPPED = 4
"""How a row is searched for: from starts of all kinds, and at last from the postures that are known;
from its own posture, those that are known, and one lot of seeds; from its own posture alone; with
few starts, since it is proved that the hand has no room at the target; the same, not at all."""
NEARER = 5
NEXT_TO = 6
"""What is asked of a row that misses its target: a posture nearer to it than one that is known, from
many starts; the same from its own posture alone."""
KNOWN_POSTURES = 2
"""How many postures may be known of a row: one that reached its target, one that came near it."""

CERTAIN = 0
OWN_WAY = 1
OTHER_WAY = 2
KEPT = 3
BURIED = 4
"""What became of a row: not in doubt; clear from its own posture; clear from another one; in doubt,
and no clear posture found; in doubt, and proved that there is none."""


class Outcome(NamedTuple):
    """What became of P rows, filled in place."""

    angles: NDArray[np.float64]
    """(P, K, 3) [rad] the free postures, in, and what they have come to, out."""
    numbers: NDArray[np.float64]
    """(P, 8) as of kernels.inverse. Of a row that is BRIEF, after, where it is KEPT: [1] the least that
    an attempt has left violated [m]. Of a row that is NEARER or NEXT_TO, before: [0] no posture misses
    the target by less [m]; [1] the miss [m] that is to be beaten."""
    overlap: NDArray[np.float64]
    """(P,) [m] depth in parts beyond what is allowed; infinite after NEARER or NEXT_TO where no
    better posture is found."""
    part: NDArray[np.int64]
    """(P,) the part that keeps the limb from its target, -1 where none does."""
    doubt: NDArray[np.int64]
    """(P,) CERTAIN, OWN_WAY, OTHER_WAY, KEPT or BURIED. Of `still_reaches`, KEPT before: the row is
    left out."""
    effort: NDArray[np.int64]
    """(P,) WHOLE, FEW_STARTS, BRIEF, NO_ROOM or SKIPPED, and NO_ROOM after where that was proved; or
    NEARER or NEXT_TO."""
    known: NDArray[np.float64]
    """(P, KNOWN_POSTURES, K, 3) [rad] postures of the rows in a place near by."""
    is_known: NDArray[np.bool_]
    """(P, KNOWN_POSTURES) whether there is such a posture."""


class Looked(NamedTuple):
    """What was looked at about P reaches, filled in place: as of `limb_contacts.Space`."""

    last: NDArray[np.float64]
    """(P, groups, S, 3) [m] where each sphere of the limb was last looked at."""
    gap: NDArray[np.float64]
    """(P, groups, S) [m] how far its centre was from all surfaces at least, -1 where not known."""


class ObstacleRow(NamedTuple):
    """One row: the limb `limbs` of row `body` of a body, with its chain `link`, among the parts of
    `room`; row `row` of held (P, J, 4), of base (P, 3, 4) and goal (P, 12) in the axes of the held
    segment, and of these in the `world` and as a `target` there."""

    link: Linkage
    limbs: Limbs
    room: Obstacles
    held: NDArray[np.float64]
    base: NDArray[np.float64]
    goal: NDArray[np.float64]
    world: NDArray[np.float64]
    target: NDArray[np.float64]
    body: int
    row: int


class Workspace(NamedTuple):
    """Working space of a search."""

    state: ChainState
    work: DescentWorkspace
    space: Space
    planes: ContactPlanes
    sphere: NDArray[np.int64]
    """(Q,) the sphere that each plane holds."""
    many: NDArray[np.int64]
    """(1,) how many planes there are."""
    trial: NDArray[np.float64]
    """(1, K, 3) angles at which contacts are found."""
    free: NDArray[np.float64]
    """(K, 3) the posture without obstacles."""
    least: NDArray[np.float64]
    """(1,) [m] the least that an attempt of this row has left violated."""
    best: NDArray[np.float64]
    """(K, 3) the posture with that."""
    blocking: NDArray[np.int64]
    """(1,) the part that was entered deepest there."""
    pool: NDArray[np.float64]
    """(POOL, K, 3) the best postures that failed, the best first."""
    rank: NDArray[np.float64]
    """(POOL,) [m] what they leave violated, infinite where there is none."""
    tried: NDArray[np.int64]
    """(M,) 1 for a seed that was used."""
    starts: NDArray[np.float64]
    """(M, K, 3) postures to start from."""
    turns: ProofWorkspace
    worth: NDArray[np.float64]
    """(M,) [m] how far a start is from being a reach; infinite where it was used."""


class Witness(NamedTuple):
    """A posture as it is: distance from the target [m], breach of the stops [rad], depth in parts
    beyond what is allowed [m], the part entered deepest, -1 where none is."""

    error: float
    breach: float
    depth: float
    part: int


def new_desk(link: Linkage, limbs: Limbs, joints: int, seeds: int) -> Workspace:
    """Working space for chains of a linkage, of bodies with so many joints."""
    count = link.axes.shape[0]
    free = link.mode.shape[0]
    rows = link.rows.shape[0] + MOST_PLANES
    return Workspace(
        new_state(count, free, rows),
        new_work(count, free, rows),
        new_space(limbs, joints),
        ContactPlanes(
            np.zeros(MOST_PLANES, np.int64),
            np.zeros((MOST_PLANES, 3)),
            np.zeros((MOST_PLANES, 3)),
            np.zeros(MOST_PLANES),
        ),
        np.zeros(MOST_PLANES, np.int64),
        np.zeros(1, np.int64),
        np.zeros((1, count, 3)),
        np.zeros((count, 3)),
        np.zeros(1),
        np.zeros((count, 3)),
        np.zeros(1, np.int64),
        np.zeros((POOL, count, 3)),
        np.zeros(POOL),
        np.zeros(seeds, np.int64),
        np.zeros((seeds, count, 3)),
        new_turns(),
        np.zeros(seeds),
    )


@inner
def _contacts(case, near, desk):  # type: ignore[no-untyped-def]
    """Find the contacts of the state within `near` [m]; returns how many."""
    put_row(desk.state.angles, desk.trial, 0)
    none = np.int64(0)  # a plain 0 would have all that it is passed to compiled for itself
    return find_contacts(
        case.limbs,
        case.body,
        case.held,
        case.world,
        case.row,
        desk.trial,
        none,
        case.room,
        near,
        desk.space,
    )


@inlined
def _turn_plane(frame, planes, m):  # type: ignore[no-untyped-def]
    """Turn plane m of the world into the axes of the held segment, and round it."""
    n = vector(planes.normal[m])
    height = planes.offset[m] - n[0] * frame[0, 3] - n[1] * frame[1, 3] - n[2] * frame[2, 3]
    planes.offset[m] = _rounded(height)
    x, y, z = transpose_matvec(rotation_part(frame), n)
    store((_rounded(x), _rounded(y), _rounded(z)), planes.normal[m])
    x, y, z = vector(planes.point[m])
    store((_rounded(x), _rounded(y), _rounded(z)), planes.point[m])


@inlined
def _rounded(number):  # type: ignore[no-untyped-def]
    """A number of a plane on its grid."""
    return np.rint(number * PLANE_GRID) / PLANE_GRID


@inner
def _make_planes(case, count, desk):  # type: ignore[no-untyped-def]
    """Make planes of the first `count` contacts, deepest first; of those of one sphere that lead the
    same way only the deepest."""
    planes = desk.planes
    sphere = desk.sphere
    many = 0
    for i in range(count):
        plane_of_contact(case.limbs, case.body, case.room, i, CLEAR, desk.space, planes, many)
        _turn_plane(case.world[case.row], planes, many)
        sphere[many] = int(desk.space.found[0, i, 1])
        same = False
        for m in range(many):
            cosine = 0.0
            for axis in range(3):
                cosine += planes.normal[m, axis] * planes.normal[many, axis]
            if sphere[m] == sphere[many] and cosine > ALIKE:
                same = True
        if not same:
            many += 1
    desk.many[0] = many


@inner
def _look(case, desk):  # type: ignore[no-untyped-def]
    """Look at a state with its planes: the distance from the target, and the breach of the stops."""
    state = desk.state
    none = np.int64(0)
    breach = 0.0
    evaluate(case.link, case.body, case.base, case.row, desk.planes, (none, desk.many[0]), state)
    error, _ = residual(case.goal, case.row, state)
    for r in range(case.link.rows.shape[0]):
        breach = max(breach, -state.room[r])
    return error, breach


@inner
def _witness(case, desk):  # type: ignore[no-untyped-def]
    """Bring the angles of a state inside what can be clipped, and say what the posture is."""
    clamp_angles(case.link, desk.state.angles)
    desk.many[0] = 0
    error, breach = _look(case, desk)
    depth = 0.0
    part = np.int64(-1)
    if _contacts(case, CLEAR, desk) > 0:
        depth = max(0.0, desk.space.found[0, 0, 0])
    if depth > 0.0:
        part = np.int64(case.room.owner[int(desk.space.found[0, 0, 2])])
    return Witness(error, breach, depth, part)  # type: ignore[arg-type]


@inlined
def _is_reach(witness, radius):  # type: ignore[no-untyped-def]
    """Whether a posture brings the tip to within a radius of the target, breaks no stop and enters
    nothing."""
    return witness.depth <= 0.0 and witness.error < radius + REACHED and witness.breach < LEGAL


@inlined
def _keep(case, witness, desk, out):  # type: ignore[no-untyped-def]
    """Keep the state as what its row has come to."""
    put_row(desk.state.angles, out.angles, case.row)
    out.numbers[case.row, 0] = witness.error
    out.numbers[case.row, 1] = witness.breach
    out.overlap[case.row] = witness.depth


@inlined
def _aim(case, error, radius, desk):  # type: ignore[no-untyped-def]
    """Pull the tip to the nearest point within a radius of the target; returns the weight of the
    tip, 0 where it is there."""
    share = 1.0 - radius / max(error, 1e-300)
    pull = PULL if share > 0.0 else 0.0
    for i in range(6):
        off = case.goal[case.row, i] - desk.state.at[i]
        desk.work.force[i] = pull * share * case.goal[case.row, 6 + i] ** 2 * off
    return pull


@inner
def _solve(case, radius, desk, out):  # type: ignore[no-untyped-def]
    """Bring the tip to within a radius of the target, the joints within their stops and the spheres
    out of all parts, from the angles of a state; True where all three are had.

    Damped Gauss-Newton steps on e^2, the s_r < 0 and the d_i < 0 (see the module's formula), with
    contacts found anew at each. The best that fails is kept on the desk.
    """
    state = desk.state
    work = desk.work
    least = np.inf
    slow = 0
    bent = np.bool_(False)
    work.pushed[:] = 0.0
    work.press[:] = 0.0
    for _ in range(MOST_STEPS):
        count = _contacts(case, HINT, desk)
        deepest = desk.space.found[0, 0, 0] + CLEAR if count > 0 else 0.0
        part = np.int64(case.room.owner[int(desk.space.found[0, 0, 2])]) if count > 0 else -1
        depth = max(0.0, deepest)
        _make_planes(case, count, desk)
        error, breach = _look(case, desk)
        gap = max(0.0, error - radius)
        if gap < ARRIVED and depth <= 0.0 and breach < INSIDE:
            return _is_reach(_witness(case, desk), radius)
        left = gap + depth + RADIAN * breach
        slow = 0 if left < BETTER * least else slow + 1
        least = min(least, left)
        if left < desk.least[0]:
            desk.least[0] = left
            desk.blocking[0] = part
            take(state.angles, desk.best)
        if slow > MOST_SLOW:
            return False
        pull = _aim(case, error, radius, desk)
        normal_equations(case.link, case.goal, case.row, state, work, pull, EASE, bent)
        out.numbers[case.row, 2] += 1
        if not newton(case.link, state, work, DAMPING):
            return False
        take_step(case.link, state, work)
    return False


@inner
def _attempt(case, desk, out):  # type: ignore[no-untyped-def]
    """Solve from a state, and put what fails into the pool; True where it is a reach."""
    desk.least[0] = np.inf
    if _solve(case, 0.0, desk, out):
        return True
    place = POOL
    while place > 0 and desk.rank[place - 1] > desk.least[0]:
        place -= 1
    if place < POOL:
        for m in range(POOL - 1, place, -1):
            desk.rank[m] = desk.rank[m - 1]
            take(desk.pool[m - 1], desk.pool[m])
        desk.rank[place] = desk.least[0]
        take(desk.best, desk.pool[place])
    return False


@inner
def _make_comfortable(case, desk, out):  # type: ignore[no-untyped-def]
    """Keep a reach, and descend from it in comfort, within planes of all that is near; the most
    comfortable reach that comes of it is kept in its place."""
    state = desk.state
    work = desk.work
    none = np.int64(0)
    cold = np.bool_(False)
    _keep(case, _witness(case, desk), desk, out)
    best = discomfort(case.link, state.angles, 0.0)
    for _ in range(EASY_TURNS):
        _make_planes(case, _contacts(case, NEAR, desk), desk)
        steps, _ = minimize(
            case.link,
            case.body,
            (case.base, case.goal),
            case.row,
            desk.planes,
            (none, desk.many[0]),
            np.int64(EASY_STEPS),
            cold,
            state,
            work,
        )
        out.numbers[case.row, 2] += steps
        witness = _witness(case, desk)
        value = discomfort(case.link, state.angles, 0.0)
        if _is_reach(witness, 0.0):
            if value < best:
                _keep(case, witness, desk, out)
            if value > GAIN * best:
                return
            best = value
        elif witness.error >= CLOSE:
            return


@inlined
def _set_free(link, angles, p, share, start, out):  # type: ignore[no-untyped-def]
    """Fill out (K, 3) with a start, its free angles going toward angles[p] by a share."""
    take(start, out)
    for d in range(link.mode.shape[0]):
        k = link.free_joint[d]
        axis = link.free_axis[d]
        out[k, axis] += share * (angles[p, k, axis] - out[k, axis])


@inlined
def _kick(link, angles, number, share, start, out):  # type: ignore[no-untyped-def]
    """Fill out (K, 3) with a start, each of its free angles going toward that of another of the
    postures angles (M, K, 3) by a share."""
    take(start, out)
    for d in range(link.mode.shape[0]):
        k = link.free_joint[d]
        axis = link.free_axis[d]
        seed = (37 * number + 11 * d + 5 * number * d) % angles.shape[0]
        out[k, axis] += share * (angles[seed, k, axis] - out[k, axis])


@inner
def _bring_seed(case, seeds, most, desk, out):  # type: ignore[no-untyped-def]
    """Make the state a start of the seed with the nearest tip that was not used, brought toward the
    target by `most` steps, obstacles aside; False where none is left."""
    none = np.int64(0)
    at = next_seed(case.base, case.goal, case.row, seeds, case.body, desk.tried)
    if at < 0:
        return False
    desk.tried[at] = 1
    desk.many[0] = 0
    desk.work.press[:] = 0.0
    _set_free(case.link, seeds.angles, at, 1.0, desk.free, desk.state.angles)
    steps, _ = minimize_distance(
        case.link,
        case.body,
        (case.base, case.goal),
        case.row,
        desk.planes,
        (none, none),
        np.int64(most),
        DISTANT_EASE,
        desk.state,
        desk.work,
    )
    out.numbers[case.row, 2] += steps
    return True


@inner
def _find_starts(case, seeds, lot, desk, out):  # type: ignore[no-untyped-def]
    """Bring the tip to the target, obstacles aside, from up to `lot` seeds that were not used, those
    with the nearest tips; returns how many starts that gives."""
    count = 0
    desk.worth[:] = np.inf
    for _ in range(lot):
        if not _bring_seed(case, seeds, TOWARD, desk, out):
            break
        witness = _witness(case, desk)
        if witness.error < CLOSE and witness.breach < OFF:
            take(desk.state.angles, desk.starts[count])
            desk.worth[count] = witness.depth + witness.error
            count += 1
    return count


@inner
def _search_about_failures(case, seeds, desk, out):  # type: ignore[no-untyped-def]
    """Seek a reach from starts about the best that failed; True where one is found."""
    for i in range(KICKS):
        if i == FIRST_KICKS and desk.rank[0] > HOPELESS:
            return False
        about = i % POOL
        if desk.rank[about] < np.inf:
            share = KICK[(i // POOL) % len(KICK)]
            _kick(case.link, seeds.angles, i, share, desk.pool[about], desk.state.angles)
            if _attempt(case, desk, out):
                return True
    return False


@inner
def _search_from_known(case, desk, out):  # type: ignore[no-untyped-def]
    """Seek a reach from the postures that are known of a row; True where one is found."""
    for i in range(KNOWN_POSTURES):
        if out.is_known[case.row, i]:
            take(out.known[case.row, i], desk.state.angles)
            if _attempt(case, desk, out):
                return True
    return False


@inner
def _search_from_seeds(case, seeds, lots, desk, out):  # type: ignore[no-untyped-def]
    """Seek a reach from the lots of starts lots[0]..lots[1], those of a lot first that enter least;
    True where one is found."""
    first, last = lots
    for n in range(first, last):
        for _ in range(_find_starts(case, seeds, LOTS[n], desk, out)):
            least = 0
            for i in range(desk.worth.shape[0]):
                if desk.worth[i] < desk.worth[least]:
                    least = i
            desk.worth[least] = np.inf
            take(desk.starts[least], desk.state.angles)
            if _attempt(case, desk, out):
                return True
    return False


@inner
def _search_on(case, seeds, lots, desk, out):  # type: ignore[no-untyped-def]
    """Go on with a whole search of so many lots of starts: seek a proof that the hand has no room,
    then a reach from the other lots, about the best that failed, and from known postures; True
    where one is found."""
    first = min(lots, LOTS_BEFORE_PROOF)
    target = vector(case.target[case.row])
    if lots > FEW_LOTS and has_no_room(
        case.limbs, case.body, case.room, target, REACHED, desk.turns, desk.space
    ):
        out.effort[case.row] = NO_ROOM
        return False
    if _search_from_seeds(case, seeds, (first, lots), desk, out):
        return True
    if lots > FEW_LOTS and _search_about_failures(case, seeds, desk, out):
        return True
    return _search_from_known(case, desk, out)


@inner
def _search(case, seeds, lots, desk, out):  # type: ignore[no-untyped-def]
    """Seek a reach from the free posture; then from so many lots of starts, and about the best that
    failed; then from known postures, which come before all others where there are few starts.
    Returns OWN_WAY, OTHER_WAY or KEPT."""
    desk.rank[:] = np.inf
    take(desk.free, desk.state.angles)
    if _attempt(case, desk, out):
        return OWN_WAY
    effort = out.effort[case.row]
    if effort != BRIEF:
        place_seeds(case.link, case.body, seeds, desk.state)
        desk.tried[:] = 0
        if effort == WHOLE:
            first = min(lots, LOTS_BEFORE_PROOF)
            if _search_from_seeds(case, seeds, (0, first), desk, out):
                return OTHER_WAY
            if _search_on(case, seeds, lots, desk, out):
                return OTHER_WAY
        else:
            if _search_from_known(case, desk, out):
                return OTHER_WAY
            few = min(lots, LOTS_OF_FEW_STARTS)
            if _search_from_seeds(case, seeds, (0, few), desk, out):
                return OTHER_WAY
    desk.least[0] = desk.rank[0]
    take(desk.pool[0], desk.best)
    return KEPT


@inner
def _buried_in(case, desk):  # type: ignore[no-untyped-def]
    """The part that the target is so deep in that no posture reaches it; -1 where that is not
    proved.

    Lemma. Let the target be D deep in a solid B, let c be the centre and r the radius of a solid
    sphere of the segment that arrives, rigid in it, d from its tip, and let the tip be within e of
    the target. Then c is within d + e of the target in every posture. A point that is nearer to the
    target than D lies inside B, since no polygon of B is between. Two cases:

    - c lies inside B, at least D - d - e deep. The solid P in which it is deepest, B or another, is
      entered by at least r + max(0, D - d - e) less the allowance of P.
    - c lies outside B, at most d + e - D from its surface. B is entered by at least r + D - d - e
      less the allowance of B.

    So where r + D - d - e exceeds the allowances of all P that there may be, each posture that
    brings the tip to the target enters something.
    """
    limbs = case.limbs
    room = case.room
    sphere = limbs.grip[case.body]
    if sphere < 0:
        return np.int64(-1)
    n = limbs.segment[sphere]
    radius = limbs.radius[case.body, sphere]
    arm = limbs.grip_arm[case.body] + REACHED
    for g in range(room.field.trees.root.shape[0]):
        if room.field.trees.root[g] < 0:
            continue
        shift = vector(room.shift[case.body]) if g == 1 else (0.0, 0.0, 0.0)
        point = subtract(vector(case.target[case.row]), shift)
        x, y, z = point
        if square_bound(x, y, z, room.field, g)[1]:
            continue
        space = desk.space
        depth, rank = penetration_depth(
            x, y, z, room.faces, room.shells, room.field, g, space.stack, space.gaps
        )
        if rank < 0:
            continue
        part = np.int64(room.owner[int(room.field.trees.record[room.field.trees.begin[rank] + 8])])
        inside = max(0.0, depth - arm)
        allowed = most_allowed(room, g, n, part, point, arm, inside)
        if radius + depth - arm - allowed > SURELY:
            return part
    return np.int64(-1)


@inner
def _come_near(case, missed, part, desk, out):  # type: ignore[no-untyped-def]
    """Keep a posture that enters nothing as near to the target as is found from a state; missed
    [m]: the miss without obstacles; part: what is in the way. The least radius is sought by widening
    until there is a posture, and then by halving."""
    low = missed
    high = np.inf
    wider = FIRST_RADIUS
    for turn in range(MOST_RADII + NARROWING):
        if high == np.inf and turn == MOST_RADII:
            return
        radius = missed + wider
        if high < np.inf:
            if high - low <= FIRST_RADIUS:
                break
            radius = 0.5 * (low + high)
            take_row(out.angles, case.row, desk.state.angles)
        desk.least[0] = np.inf
        if _solve(case, radius, desk, out):
            witness = _witness(case, desk)
            _keep(case, witness, desk, out)
            high = min(radius, witness.error)
        else:
            low = radius
            wider *= WIDENING
            part = desk.blocking[0] if desk.blocking[0] >= 0 else part
            take(desk.best, desk.state.angles)
    out.part[case.row] = part if low > missed or missed <= NEARLY else -1


@inner
def _within_radius(case, radius, desk, out):  # type: ignore[no-untyped-def]
    """Seek a posture that enters nothing and misses the target by a radius at most, from the state
    of a row. It is kept where there is one: then its miss [m] is returned, else infinity."""
    desk.least[0] = np.inf
    if not _solve(case, radius, desk, out):
        return np.inf
    witness = _witness(case, desk)
    _keep(case, witness, desk, out)
    return min(radius, witness.error)


@inner
def _narrow(case, low, high, desk, out):  # type: ignore[no-untyped-def]
    """Halve the radius about the target, from the posture that is kept of a row: that misses it by
    `high` [m], and `low` [m] is out of reach. Returns the least miss that was had [m]."""
    for _ in range(MOST_HALVINGS):
        if high - low <= PRECISE:
            break
        radius = 0.5 * (low + high)
        take_row(out.angles, case.row, desk.state.angles)
        had = _within_radius(case, radius, desk, out)
        if had < np.inf:
            high = had
        else:
            low = radius
            out.part[case.row] = desk.blocking[0]
    return high


@inner
def _beat(case, least, high, desk, out):  # type: ignore[no-untyped-def]
    """Seek a posture that misses the target by less than `high` [m], from the state of a row; no
    posture misses it by less than `least` [m]. Returns the least miss that was had [m]."""
    had = _within_radius(case, least + BOLD * (high - least), desk, out)
    if had == np.inf:
        take(desk.best, desk.state.angles)
        had = _within_radius(case, least + TIMID * (high - least), desk, out)
    if had == np.inf:
        return high
    return _narrow(case, least, had, desk, out)


@inner
def _come_nearer(case, seeds, many, desk, out):  # type: ignore[no-untyped-def]
    """Seek a posture that enters nothing and is nearer to the target than is known: from the state of
    a row, and where `many`, from starts about the best and from seeds. The best is kept; True where
    it is a reach."""
    least = out.numbers[case.row, 0]
    high = out.numbers[case.row, 1]
    out.overlap[case.row] = np.inf
    witness = _witness(case, desk)
    take(desk.state.angles, desk.free)
    if witness.depth <= 0.0 and witness.breach < LEGAL and witness.error < high:
        _keep(case, witness, desk, out)
        high = witness.error
    high = _beat(case, least, high, desk, out)
    if many:
        place_seeds(case.link, case.body, seeds, desk.state)
        desk.tried[:] = 0
        for i in range(NEARER_KICKS + NEARER_SEEDS):
            if high - least <= PRECISE:
                break
            if out.overlap[case.row] < np.inf:
                take_row(out.angles, case.row, desk.free)
            if i < NEARER_KICKS:
                _kick(case.link, seeds.angles, i, KICK[i % len(KICK)], desk.free, desk.state.angles)
            elif not _bring_seed(case, seeds, TOWARD * (i % 2), desk, out):
                break
            high = _beat(case, least, high, desk, out)
    if least > 0.0 or high > CLOSE or out.overlap[case.row] == np.inf:
        return False
    take_row(out.angles, case.row, desk.state.angles)
    desk.least[0] = np.inf
    if not _solve(case, 0.0, desk, out):
        return False
    _make_comfortable(case, desk, out)
    return True


@batch_loop
def clear_reaches(link, limbs, who, held, problem, room, seeds, out, begin, end, desk):  # type: ignore[no-untyped-def]
    """Keep reaches clear of obstacles, rows begin..end of P, each by itself.

    link, limbs: of B bodies; who (P,): the body of each row; held (P, J, 4); problem: base (P, 3,
    4) and goal (P, 12) in the axes of the held segments, and in the world; room: the parts; seeds: postures to begin at;
    out: the Outcome; desk: working space.
    """
    base, goal, world, target = problem
    last = np.int64(-1), np.int64(-1)
    for p in range(begin, end):
        here = np.int64(who[p]), way_of_people(room, p)
        if here != last:
            forget(desk.space)
            last = here
        case = ObstacleRow(link, limbs, room, held, base, goal, world, target, who[p], p)
        take_row(out.angles, p, desk.state.angles)
        if out.effort[p] >= NEARER:
            many = out.effort[p] == NEARER
            out.doubt[p] = OTHER_WAY if _come_nearer(case, seeds, many, desk, out) else KEPT
            continue
        free = _witness(case, desk)
        take(desk.state.angles, desk.free)
        out.overlap[p] = free.depth
        out.part[p] = free.part
        brief = out.effort[p] == BRIEF
        out.doubt[p] = CERTAIN
        desk.least[0] = np.inf
        desk.blocking[0] = free.part
        missed = out.numbers[p, 0]
        buried = np.int64(-1)
        if _is_reach(free, 0.0) or (free.depth <= 0.0 and missed > NEARLY):
            continue
        if out.effort[p] == SKIPPED:
            out.doubt[p] = BURIED
            continue
        if missed <= NEARLY:
            lots = len(LOTS) if free.depth > 0.0 else FEW_LOTS
            if free.depth > 0.0:
                buried = _buried_in(case, desk)
            lots = lots if buried < 0 else LOTS_OF_BURIED
            out.doubt[p] = _search(case, seeds, lots, desk, out)
            if out.doubt[p] == KEPT and (buried >= 0 or out.effort[p] == NO_ROOM):
                out.doubt[p] = BURIED
            if out.doubt[p] < KEPT:
                _make_comfortable(case, desk, out)
                out.part[p] = -1
                continue
            if brief:
                out.numbers[p, 1] = desk.least[0]
                continue
            take(desk.best, desk.state.angles)
        if free.depth > 0.0:
            _come_near(case, missed, free.part, desk, out)
        if buried >= 0 and out.doubt[p] == BURIED:
            out.part[p] = buried


@batch_loop
def prove_no_room(limbs, who, targets, room, proved, begin, end, space, turns):  # type: ignore[no-untyped-def]
    """Prove of the rows begin..end of P that the hand of body who[p] has no room at target p,
    however it is turned; proved (P,) is filled with 1 where there is a proof, else 0;
    space, turns: working arrays."""
    for p in range(begin, end):
        forget(space)
        target = vector(targets[p])
        proved[p] = has_no_room(limbs, who[p], room, target, REACHED, turns, space)


@inner
def _follow_tip(case, desk):  # type: ignore[no-untyped-def]
    """Bring the tip to the target from a state near by, obstacles aside: that spares most of the
    looks at them."""
    desk.work.pushed[:] = 0.0
    desk.work.press[:] = 0.0
    desk.many[0] = 0
    bent = np.bool_(False)
    for _ in range(FOLLOWING_STEPS):
        error, breach = _look(case, desk)
        if error < ARRIVED and breach < INSIDE:
            return
        pull = _aim(case, error, 0.0, desk)
        normal_equations(case.link, case.goal, case.row, desk.state, desk.work, pull, EASE, bent)
        if not newton(case.link, desk.state, desk.work, DAMPING):
            return
        take_step(case.link, desk.state, desk.work)


@inlined
def _copy_looked(last, gap, to_last, to_gap):  # type: ignore[no-untyped-def]
    """Copy what was looked at about one reach."""
    for g in range(gap.shape[0]):
        for s in range(gap.shape[1]):
            to_gap[g, s] = gap[g, s]
            for axis in range(3):
                to_last[g, s, axis] = last[g, s, axis]


@batch_loop
def still_reaches(link, limbs, who, held, problem, room, looked, out, begin, end, desk):  # type: ignore[no-untyped-def]
    """Look whether reaches are still there once their people are elsewhere, rows begin..end of P.

    Each begins from its posture before, in `out.angles`, and is a reach where the search from there
    finds one: then `out.doubt` is OWN_WAY, and the posture is the new one. Else it is KEPT, and the
    posture stays. Rows that are KEPT before are left out.

    looked: a `Looked` in the same room, with the same parts shown; the others as of `clear_reaches`.
    """
    base, goal, world, target = problem
    space = desk.space
    for p in range(begin, end):
        if out.doubt[p] == KEPT:
            continue
        case = ObstacleRow(link, limbs, room, held, base, goal, world, target, who[p], p)
        _copy_looked(looked.last[p], looked.gap[p], space.last, space.gap)
        take_row(out.angles, p, desk.state.angles)
        desk.least[0] = np.inf
        _follow_tip(case, desk)
        if _solve(case, 0.0, desk, out):
            put_row(desk.state.angles, out.angles, p)
            out.doubt[p] = OWN_WAY
        else:
            out.doubt[p] = KEPT
        _copy_looked(space.last, space.gap, looked.last[p], looked.gap[p])
