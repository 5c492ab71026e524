"""How long the segments of a recorded subject are, by the file's own lengths: bones, markers, or
segments told one by one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.motion import Bones, Markers, SegmentTrack
from workbench.motion.recorded.bone_names import bone_map
from workbench.motion.recorded.marker_names import Site, marker_site
from workbench.motion.recorded.marker_places import marker_places
from workbench.motion.recorded.retarget import body_lengths, bone_lengths

__all__ = ["TRUNK", "factors_from_bones", "factors_from_markers", "factors_from_track"]

TRUNK = ("CT", "UT")
"""What grows with the length from the hips to the shoulders."""
_LIMBS = {"LUA": "RUA", "LLA": "RLA", "LUL": "RUL", "LLL": "RLL"}
_AXIS = {
    "UA": ("S", "E"),
    "LA": ("E", "W"),
    "UL": ("H", "K"),
    "LL": ("K", "A"),
    "CT": ("W", "SP"),
    "UT": ("SP", "NP"),
}
_FRAMES = 2000
_LOOSE = 0.02
# segments, and the segments and directions of two groups of markers whose distance hardly depends
# on the pose
_SPANS: tuple[tuple[tuple[str, ...], tuple[str, str, str], tuple[str, str, str]], ...] = (
    (("LL",), ("UL", "K", ""), ("LL", "A", "")),
    (("LA",), ("UA", "E", ""), ("LA", "W", "")),
    (("UL",), ("UL", "H", ""), ("UL", "K", "")),
    (("UA",), ("SM", "S", "top"), ("UA", "E", "")),
)


def factors_from_bones(
    body: Body, bones: Bones, names: Mapping[str, str] | None, metres: float
) -> dict[str, float]:
    """How many times as long as the body's the limbs and the trunk of a skeleton are, by segment;
    both sides alike.

    metres: one unit of the file [m]. The trunk is told from the middle of the hips to that of the
    shoulders, at rest.
    """
    chosen = bone_map(bones, names)
    found = bone_lengths(bones, chosen)
    own = body_lengths(body)
    factors: dict[str, float] = {}
    for left, right in _LIMBS.items():
        have = [(found[s] * metres, own[s]) for s in (left, right) if found.get(s, 0.0) > 0.0]
        if have:
            factors[left] = factors[right] = sum(a for a, _ in have) / sum(b for _, b in have)
    rest = np.array(bones.offset)
    for b, parent in enumerate(bones.parent):
        rest[b] += rest[parent] if parent >= 0 else 0.0
    at = {s: rest[bones.names.index(chosen[s])] for s in ("LUL", "RUL", "LUA", "RUA")}
    length = float(np.linalg.norm(at["LUA"] + at["RUA"] - at["LUL"] - at["RUL"])) * 0.5 * metres
    joint = _joints(body)
    ours = 0.5 * float(np.linalg.norm(joint["LS"] + joint["RS"] - joint["LH"] - joint["RH"]))
    pelvis = float(joint["W"][2] - 0.5 * (joint["LH"][2] + joint["RH"][2]))  # keeps its height
    return factors | dict.fromkeys(TRUNK, (length - pelvis) / (ours - pelvis))


def factors_from_markers(
    body: Body, markers: Markers, names: Mapping[str, str] | None
) -> dict[str, float]:
    """The same from markers: median distances of markers at knees and ankles, elbows and wrists,
    hips and knees, shoulders and elbows, against those of the body's own places for them."""
    given = dict(names or {})
    sites = {
        name: site
        for name in markers.names
        if (site := marker_site(given.get(name, name))) is not None
    }
    sites = {name: site for name, site in sites.items() if given.get(name, name)}
    if not sites:
        return {}
    local, _ = marker_places(body, sites)
    origin = body.zero_origins[0]
    own = {
        name: origin[body.segment(site.segment)] + local[m]
        for m, (name, site) in enumerate(sites.items())
    }
    factors: dict[str, float] = {}
    for segments, one, other in _SPANS:
        rows = [
            row for side in "LR" for row in [_span(markers, own, sites, (side, one, other))] if row
        ]
        if rows:
            share = sum(a for a, _ in rows) / sum(b for _, b in rows)
            factors |= {side + s: share for s in segments for side in "LR"}
    if "LLL" in factors:
        factors.setdefault("LUL", factors["LLL"])
        factors.setdefault("RUL", factors["RLL"])
    return factors


def factors_from_track(body: Body, track: SegmentTrack) -> dict[str, float]:
    """The same from segments told one by one: joints are where two segments stay together (Ehrig,
    Taylor, Duda & Heller, J. Biomech. 39, 2006), where they turn enough against each other to
    tell."""
    world = track.world_from_segment[:_FRAMES]
    known = {s: k for k, s in enumerate(track.segments)}
    ends: dict[str, dict[str, Floats]] = {}
    for j, joint in enumerate(body.joints):
        parent = body.segments[int(body.parent[j + 1])]
        child = body.segments[j + 1]
        if parent in known and child in known:
            found = _centre(world[:, known[parent]], world[:, known[child]])
            if found is not None:
                ends.setdefault(parent, {})[joint] = found[:3]
                ends.setdefault(child, {})[joint] = found[3:]
    factors = {}
    for segment, joints in ends.items():
        pair = _AXIS.get(segment if segment in TRUNK else segment[1:])
        if pair is None:
            continue
        first, last = (name if segment in TRUNK else segment[0] + name for name in pair)
        if first in joints and last in joints and {first, last} <= set(body.joints):
            ours = (
                body.joint_in_parent[0, body.joint(last)]
                - body.joint_in_child[0, body.joint(first)]
            )
            factors[segment] = float(
                np.linalg.norm(joints[last] - joints[first]) / np.linalg.norm(ours)
            )
    return factors


def _centre(parent: Floats, child: Floats) -> Floats | None:
    """(6,) [m] the joint in the parent's frame and in the child's; None where they hardly turn, or
    do not hold."""
    matrix = np.concatenate([parent[:, :, :3], -child[:, :, :3]], axis=-1).reshape(-1, 6)
    apart = (child[:, :, 3] - parent[:, :, 3]).reshape(-1)
    found, _, rank, values = np.linalg.lstsq(matrix, apart, rcond=None)
    if rank < 6 or values[-1] < 0.1 * values[0]:
        return None
    off = float(np.sqrt(np.mean((matrix @ found - apart) ** 2)))
    return np.asarray(found) if off < _LOOSE else None


def _span(
    markers: Markers,
    own: Mapping[str, Floats],
    sites: Mapping[str, Site],
    where: tuple[str, tuple[str, str, str], tuple[str, str, str]],
) -> tuple[float, float] | None:
    """Median distance [m] of two groups of markers, and that of their places on the body; None
    where one lacks."""
    side, *ends = where
    seen = []
    ours = []
    for segment, joint, toward in ends:
        names = [
            n
            for n, s in sites.items()
            if s.segment == side + segment
            and s.joints == (side + joint,)
            and (not toward or toward in s.toward)
        ]
        names = [n for n in names if np.isfinite(markers.position[:, markers.names.index(n)]).any()]
        if not names:
            return None
        seen.append(markers.position[:, [markers.names.index(n) for n in names]].mean(axis=1))
        ours.append(np.mean([own[n] for n in names], axis=0))
    apart = np.linalg.norm(seen[1] - seen[0], axis=1)
    if not np.isfinite(apart).any():
        return None
    return float(np.nanmedian(apart)), float(np.linalg.norm(ours[1] - ours[0]))


def _joints(body: Body) -> dict[str, Floats]:
    """(3,) [m] each joint in the zero pose."""
    at = body.zero_origins[0]
    return {name: at[j + 1] + body.joint_in_child[0, j] for j, name in enumerate(body.joints)}
