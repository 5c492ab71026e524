"""Measure the segment lengths of a recorded subject, as factors on those of a body.

Lengths come from the file itself: from its bones, from distances between markers, or from the
joints that its segments' motions imply.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.motion import Bones, Markers, SegmentTrack
from workbench.motion.recorded.bone_names import bone_map
from workbench.motion.recorded.marker_names import Site, named_sites
from workbench.motion.recorded.skeleton import body_lengths, bone_lengths

__all__ = [
    "TRUNK",
    "factors_from_bones",
    "factors_from_markers",
    "factors_from_track",
    "height_of",
    "marker_places",
]

TRUNK = ("CT", "UT")
"""Segments that grow with the distance from the hips to the shoulders."""
_SIDES = {"LUA": "RUA", "LLA": "RLA", "LUL": "RUL", "LLL": "RLL"}
"""Limb segments of the left side and their right counterparts."""
_AXIS = {
    "UA": ("S", "E"),
    "LA": ("E", "W"),
    "UL": ("H", "K"),
    "LL": ("K", "A"),
    "CT": ("W", "SP"),
    "UT": ("SP", "NP"),
}
"""Joints at both ends of a segment, without the side."""
_MAX_FRAMES = 2000
"""Frames of a track from which joints are estimated."""
_MIN_TURN = 0.1
"""Least ratio of the singular values of a joint's equations: less turning does not determine it."""
_MAX_JOINT_RESIDUAL = 0.02
"""Root mean square distance [m] up to which two segments have a joint in common."""


class _MarkerGroup(NamedTuple):
    """Markers of a segment at a joint, without the side."""

    segment: str
    joint: str
    toward: str = ""
    """Word that the direction of their site has, "" for any."""


_SPANS = (
    ("LL", _MarkerGroup("UL", "K"), _MarkerGroup("LL", "A")),
    ("LA", _MarkerGroup("UA", "E"), _MarkerGroup("LA", "W")),
    ("UL", _MarkerGroup("UL", "H"), _MarkerGroup("UL", "K")),
    ("UA", _MarkerGroup("SM", "S", "top"), _MarkerGroup("UA", "E")),
)
"""Segments, and two groups of markers whose distance hardly depends on the pose."""


def factors_from_bones(
    body: Body, bones: Bones, names: Mapping[str, str] | None, metres: float
) -> dict[str, float]:
    """Compute the lengths of a skeleton's limbs and trunk as multiples of the body's.

    The trunk is measured from the middle of the hips to that of the shoulders, in the median of the
    frames. The pelvis keeps its height. Both sides get the mean of both.

    Parameters
    ----------
    names
        Bones by segment, where the usual names do not apply.
    metres
        One unit of the file [m].

    Returns
    -------
    dict
        Factors by segment.
    """
    bone = bone_map(bones, names)
    lengths = bone_lengths(bones, bone)
    own = body_lengths(body)
    factors: dict[str, float] = {}
    for left, right in _SIDES.items():
        known = [side for side in (left, right) if lengths.get(side, 0.0) > 0.0]
        if known:
            seen = sum(lengths[side] * metres for side in known)
            factors[left] = factors[right] = seen / sum(own[side] for side in known)
    return factors | dict.fromkeys(TRUNK, _trunk_factor(body, lengths["trunk"] * metres))


def _trunk_factor(body: Body, length: float) -> float:
    """Factor on the trunk that makes it `length` [m] from the hips to the shoulders."""
    origin = body.zero_origins[0]
    joint = {name: origin[j + 1] + body.joint_in_child[0, j] for j, name in enumerate(body.joints)}
    own = float(np.linalg.norm(joint["LS"] + joint["RS"] - joint["LH"] - joint["RH"])) * 0.5
    pelvis = float(joint["W"][2] - 0.5 * (joint["LH"][2] + joint["RH"][2]))
    return (length - pelvis) / (own - pelvis)


def factors_from_markers(
    body: Body, markers: Markers, names: Mapping[str, str] | None
) -> dict[str, float]:
    """Compute the lengths of a subject's limbs as multiples of the body's, from markers.

    Median distances of markers at hips and knees, knees and ankles, shoulders and elbows, elbows
    and wrists are compared with the distances of their places on the body. Both sides get the mean
    of both. A thigh without hip markers grows as its shank.

    Parameters
    ----------
    names
        The usual names of markers with unusual ones, "" to leave a marker out.

    Returns
    -------
    dict
        Factors by segment; empty if no marker is known.
    """
    sites = named_sites(markers, names or {})
    if not sites:
        return {}
    local, _ = marker_places(body, sites)
    origin = body.zero_origins[0]
    places = {
        name: origin[body.segment(site.segment)] + place
        for (name, site), place in zip(sites.items(), local, strict=True)
    }
    factors: dict[str, float] = {}
    for segment, one, other in _SPANS:
        spans = [_span(markers, sites, places, side, (one, other)) for side in "LR"]
        known = [span for span in spans if span is not None]
        if known:
            factor = sum(span.seen for span in known) / sum(span.own for span in known)
            factors |= {side + segment: factor for side in "LR"}
    if "LLL" in factors:
        factors.setdefault("LUL", factors["LLL"])
        factors.setdefault("RUL", factors["RLL"])
    return factors


class _Span(NamedTuple):
    """A distance between two groups of markers [m]."""

    seen: float
    """Median over the frames."""
    own: float
    """On the body."""


def _span(
    markers: Markers,
    sites: Mapping[str, Site],
    places: Mapping[str, Floats],
    side: str,
    ends: Iterable[_MarkerGroup],
) -> _Span | None:
    """The distance of two groups on a side, None where one of them is not seen."""
    groups = [list(_members(markers, sites, side, end)) for end in ends]
    if not all(groups):
        return None
    seen = [
        markers.position[:, [markers.names.index(name) for name in group]].mean(axis=1)
        for group in groups
    ]
    own = [np.mean([places[name] for name in group], axis=0) for group in groups]
    distance = np.linalg.norm(seen[1] - seen[0], axis=1)
    if not np.isfinite(distance).any():
        return None
    return _Span(float(np.nanmedian(distance)), float(np.linalg.norm(own[1] - own[0])))


def _members(
    markers: Markers, sites: Mapping[str, Site], side: str, group: _MarkerGroup
) -> Iterator[str]:
    """The markers of a group that some frame shows."""
    for name, site in sites.items():
        at_joint = site.segment == side + group.segment and site.joints == (side + group.joint,)
        seen = np.isfinite(markers.position[:, markers.names.index(name)]).any()
        if at_joint and seen and (not group.toward or group.toward in site.toward):
            yield name


def factors_from_track(body: Body, track: SegmentTrack) -> dict[str, float]:
    """Compute the lengths of recorded segments as multiples of the body's.

    A joint is the point at which two segments stay together [1]_. It is found only where the
    segments turn enough against each other.

    Returns
    -------
    dict
        Factors by segment, of those whose both joints are found.

    References
    ----------
    .. [1] R. M. Ehrig, W. R. Taylor, G. N. Duda & M. O. Heller (2006), A survey of formal methods
       for determining the centre of rotation of ball joints, Journal of Biomechanics 39, 2798-2809
       (symmetrical centre of rotation estimation).
    """
    ends = _joint_estimates(body, track)
    factors = {}
    for segment, joints in ends.items():
        bare = segment if segment in TRUNK else segment[1:]
        side = "" if segment in TRUNK else segment[0]
        pair = [side + name for name in _AXIS.get(bare, ())]
        if pair and all(name in joints and name in body.joints for name in pair):
            first, last = pair
            start = body.joint_in_child[0, body.joint(first)]
            own = body.joint_in_parent[0, body.joint(last)] - start
            length = np.linalg.norm(joints[last] - joints[first])
            factors[segment] = float(length / np.linalg.norm(own))
    return factors


def _joint_estimates(body: Body, track: SegmentTrack) -> dict[str, dict[str, Floats]]:
    """(3,) [m] of joints in their segments' frames, by segment and joint."""
    world = track.world_from_segment[:_MAX_FRAMES]
    column = {segment: k for k, segment in enumerate(track.segments)}
    ends: dict[str, dict[str, Floats]] = {}
    for j, joint in enumerate(body.joints):
        parent = body.segments[int(body.parent[j + 1])]
        child = body.segments[j + 1]
        if parent not in column or child not in column:
            continue
        centre = _rotation_centre(world[:, column[parent]], world[:, column[child]])
        if centre is not None:
            ends.setdefault(parent, {})[joint] = centre.in_parent
            ends.setdefault(child, {})[joint] = centre.in_child
    return ends


@dataclass(frozen=True, eq=False)
class _RotationCentre:
    """A joint between two segments, (3,) [m] in either frame."""

    in_parent: Floats
    in_child: Floats


def _rotation_centre(parent: Floats, child: Floats) -> _RotationCentre | None:
    """The joint of two segments, world from segment (P, 3, 4).

    None where they hardly turn against each other, or have no point in common. The least-squares
    solution of R1 c1 + t1 = R2 c2 + t2 over all frames gives c1 and c2, in 3 P equations.
    """
    matrix = np.concatenate([parent[:, :, :3], -child[:, :, :3]], axis=-1).reshape(-1, 6)
    offset = (child[:, :, 3] - parent[:, :, 3]).reshape(-1)
    solution, _, rank, singular = np.linalg.lstsq(matrix, offset, rcond=None)
    if rank < 6 or singular[-1] < _MIN_TURN * singular[0]:
        return None
    residual = float(np.sqrt(np.mean((matrix @ solution - offset) ** 2)))
    if residual >= _MAX_JOINT_RESIDUAL:
        return None
    return _RotationCentre(solution[:3], solution[3:])


_MARKER_RADIUS = 0.007
"""Radius [m] of a marker, whose centre is recorded."""
_SITE_STATURE = 1.75
"""Stature [m] of the body in which the shifts of sites are given."""


def marker_places(body: Body, sites: Mapping[str, Site]) -> tuple[Floats, Floats]:
    """Compute the places of M markers on a body.

    Returns
    -------
    tuple of Floats
        Centres (M, 3) [m] in the segments' frames, and the spread (M,) [m] of real markers.
    """
    scale = height_of(body) / _SITE_STATURE
    places = [_place(body, site, scale) for site in sites.values()]
    return np.array(places), np.array([site.spread for site in sites.values()])


def height_of(body: Body) -> float:
    """Height [m] of a body in the zero pose, from the lowest to the highest sphere."""
    z = body.zero_origins[0, body.sphere_segment, 2] + body.centre[0, :, 2]
    return float((z + body.radius[0]).max() - (z - body.radius[0]).min())


def _place(body: Body, site: Site, scale: float) -> Floats:
    """(3,) [m] centre of a marker in its segment's frame; scale: of the site's shift."""
    segment = body.segment(site.segment)
    outward = 1.0 if site.side == "L" else -1.0
    shift = np.array(site.shift) * np.array([1.0, outward, 1.0]) * scale
    base = _base(body, segment, site) + shift
    direction = _direction(site.toward, outward)
    return np.asarray(base + direction * (_skin(body, segment, base, direction) + _MARKER_RADIUS))


def _base(body: Body, segment: int, site: Site) -> Floats:
    """(3,) [m] the origin, one joint, or a point between two joints, in the segment's frame."""
    points = [
        body.joint_in_child[0, j] if segment == j + 1 else body.joint_in_parent[0, j]
        for j in map(body.joint, site.joints)
    ]
    if not points:
        return np.zeros(3)
    if len(points) == 1:
        return np.asarray(points[0])
    return np.asarray(points[0] + site.along * (points[1] - points[0]))


def _direction(words: str, outward: float) -> Floats:
    """(3,) unit vector of the sum of directions by name; outward: the sign of y on this side."""
    vectors = {
        "front": (1, 0, 0),
        "back": (-1, 0, 0),
        "top": (0, 0, 1),
        "out": (0, outward, 0),
        "in": (0, -outward, 0),
    }
    total: Floats = np.sum([vectors[word] for word in words.split()], axis=0, dtype=np.float64)
    return total / np.linalg.norm(total)


def _skin(body: Body, segment: int, origin: Floats, direction: Floats) -> float:
    """Distance [m] at which a ray leaves the last sphere of a segment, 0 if it meets none."""
    spheres = body.spheres(segment)
    # a sphere at gap g with g.d = s is left at s + sqrt(r^2 - (g.g - s^2))
    gap = body.centre[0, spheres] - origin
    along = gap @ direction
    half_chord_squared = body.radius[0, spheres] ** 2 - (np.sum(gap**2, axis=1) - along**2)
    met = half_chord_squared > 0
    return float(np.max(along[met] + np.sqrt(half_chord_squared[met]), initial=0.0))
