"""Find where a marker sits on a body by its name.

Known names are those of Plug-in-Gait, the OpenSim gait and running sets, and near relations.
"""

from __future__ import annotations

import re
from typing import NamedTuple

__all__ = ["USUAL_SPREAD", "Site", "marker_site"]


class Site(NamedTuple):
    """Where a marker sits on the skin of a segment.

    A ray runs from a base in the given direction. The marker is where the ray leaves the segment.
    In the table below `~` stands for the side.
    """

    segment: str
    joints: tuple[str, ...]
    """The base is the segment's origin, one joint, or a point between two joints."""
    along: float
    """Share of the way from the first to the second joint."""
    shift: tuple[float, float, float]
    """Displacement (3,) [m] of the base in a body of 1.75 m, x forward, y toward the marker's side,
    z up."""
    toward: str
    """Direction of the ray: words of front, back, top, in and out. `out` is away from the middle of
    the body."""
    spread: float
    """Standard distance [m] of real markers from the place, over laboratories and people."""
    side: str = ""
    """ "L", "R", or "" for the middle of the body."""


_BONY_SPREAD = 0.012
"""Spread [m] of markers on palpable bone."""
USUAL_SPREAD = 0.025
"""Spread [m] of markers near a landmark."""
_LOOSE_SPREAD = 0.05
"""Spread [m] of markers somewhere on a segment."""
_NONE = (0.0, 0.0, 0.0)
_SITES: tuple[tuple[str, Site], ...] = (
    (r"~fhd|~frontalhead", Site("H", (), 0, (0.06, 0.06, 0.05), "front out", USUAL_SPREAD)),
    (r"~temple", Site("H", (), 0, (0.02, 0.0, 0.04), "out", USUAL_SPREAD)),
    (r"~bhd|~backhead", Site("H", (), 0, (-0.06, 0.06, 0.05), "back out", USUAL_SPREAD)),
    (r"ariel|tophead|vertex", Site("H", (), 0, _NONE, "top", USUAL_SPREAD)),
    (r"c7", Site("UT", ("NP",), 0, (0, 0, 0.02), "back", USUAL_SPREAD)),
    (r"t10|t8", Site("UT", ("SP", "NP"), 0.25, _NONE, "back", _LOOSE_SPREAD)),
    (r"clav|ij|sternum", Site("UT", ("LC", "RC"), 0.5, (0, 0, 0.01), "front", USUAL_SPREAD)),
    (r"strn|px", Site("UT", ("SP", "NP"), 0.35, _NONE, "front", _LOOSE_SPREAD)),
    (
        r"~sho|~acr|~acromi(um|on)|~shoulder|~shld",
        Site("~SM", ("~S",), 0, (0, 0, 0.03), "top", USUAL_SPREAD),
    ),
    (r"~fsh|~ash", Site("~SM", ("~S",), 0, _NONE, "front", _LOOSE_SPREAD)),
    (r"~bsh|~psh", Site("~SM", ("~S",), 0, _NONE, "back", _LOOSE_SPREAD)),
    (r"~upa|~bicep|~uparm|~ua[123]", Site("~UA", ("~S", "~E"), 0.55, _NONE, "out", _LOOSE_SPREAD)),
    (r"~iel|~mel|~elbowmed(ial)?|~elbm", Site("~UA", ("~E",), 0, _NONE, "in", _BONY_SPREAD)),
    (r"~elb|~lel|~elbowlat(eral)?|~elbow", Site("~UA", ("~E",), 0, _NONE, "out", _BONY_SPREAD)),
    (
        r"~frm|~forearm|~fra|~fasuperior",
        Site("~LA", ("~E", "~W"), 0.5, _NONE, "out", _LOOSE_SPREAD),
    ),
    (r"~wre", Site("~LA", ("~E", "~W"), 0.4, _NONE, "front", _LOOSE_SPREAD)),
    (
        r"~wra|~(fa)?radius|~iwr|~wristlat(eral)?",
        Site("~LA", ("~W",), 0, _NONE, "front", USUAL_SPREAD),
    ),
    (
        r"~wrb|~(fa)?ulna|~owr|~wristmed(ial)?",
        Site("~LA", ("~W",), 0, _NONE, "back", USUAL_SPREAD),
    ),
    (r"~wri|~wrist", Site("~LA", ("~W",), 0, _NONE, "out", USUAL_SPREAD)),
    (r"~fin|~hand|~ohand", Site("~HN", (), 0, _NONE, "out", _LOOSE_SPREAD)),
    (r"~ihand", Site("~HN", (), 0, _NONE, "in", _LOOSE_SPREAD)),
    (r"~asis?|~fwt", Site("LT", ("~H",), 0, (0, 0.035, 0.085), "front", USUAL_SPREAD)),
    (r"~psis?|~bwt", Site("LT", ("~H",), 0, (0, -0.04, 0.095), "back", USUAL_SPREAD)),
    (
        r"vsac(ral)?|sacr(um|al)?|vsacral",
        Site("LT", ("LH", "RH"), 0.5, (0, 0, 0.09), "back", USUAL_SPREAD),
    ),
    (r"~mwt|~iliaccrest|~iliac", Site("LT", ("~H",), 0, (0, 0, 0.13), "out", USUAL_SPREAD)),
    (r"~gtr|~troch(anter)?", Site("~UL", ("~H",), 0, (0, 0, -0.01), "out", USUAL_SPREAD)),
    (r"~hip", Site("~UL", ("~H", "~K"), 0.2, _NONE, "out", 0.10)),
    (
        r"~thi|~thigh|~thighupper|~thighrear|~th[123]",
        Site("~UL", ("~H", "~K"), 0.55, _NONE, "out", _LOOSE_SPREAD),
    ),
    (r"~thighfront", Site("~UL", ("~H", "~K"), 0.5, _NONE, "front", _LOOSE_SPREAD)),
    (r"~kni|~mfc|~kneemed(ial)?|~kne_2|~mknee", Site("~UL", ("~K",), 0, _NONE, "in", _BONY_SPREAD)),
    (r"~kne|~lfc|~kneelat(eral)?|~knee", Site("~UL", ("~K",), 0, _NONE, "out", _BONY_SPREAD)),
    (r"~hf|~fibula", Site("~LL", ("~K", "~A"), 0.1, _NONE, "out", USUAL_SPREAD)),
    (r"~tt|~tibialtuberosity", Site("~LL", ("~K", "~A"), 0.12, _NONE, "front", USUAL_SPREAD)),
    (
        r"~tib|~sha|~shank|~shankupper|~shankrear|~shn|~tb[123]",
        Site("~LL", ("~K", "~A"), 0.5, _NONE, "out", _LOOSE_SPREAD),
    ),
    (r"~shankfront", Site("~LL", ("~K", "~A"), 0.4, _NONE, "front", _LOOSE_SPREAD)),
    (
        r"~anklemed(ial)?|~ank_2|~mank(le)?|~mmal",
        Site("~LL", ("~A",), 0, _NONE, "in", _BONY_SPREAD),
    ),
    (r"~ank|~anklelat(eral)?|~ankle|~lmal", Site("~LL", ("~A",), 0, _NONE, "out", _BONY_SPREAD)),
    (r"~hee|~hel|~heel|~calc?", Site("~F", (), 0, _NONE, "back", USUAL_SPREAD)),
    (r"~toe|~mt2|~toetip", Site("~F", (), 0, _NONE, "front", USUAL_SPREAD)),
    (r"~midfootsup(erior)?", Site("~F", (), 0, (0.02, 0.0, 0), "top", _LOOSE_SPREAD)),
    (r"~midfootlat(eral)?", Site("~F", (), 0, (0.01, 0.01, 0), "out", _LOOSE_SPREAD)),
    (r"~mt1|~toemed(ial)?", Site("~F", (), 0, (0.04, -0.01, 0), "in", _LOOSE_SPREAD)),
    (r"~mt5|~toelat(eral)?", Site("~F", (), 0, (0.03, 0.01, 0), "out", _LOOSE_SPREAD)),
)


def marker_site(name: str) -> Site | None:
    """Return the site of a marker by its name, None for an unknown name.

    A prefix up to a colon, dots, case and underscores are ignored. The suffix `_2` of a repeated
    name counts: it is the medial one of two markers.
    """
    bare = name.rsplit(":", 1)[-1].lower()
    repeated = "_2" if bare.endswith("_2") else ""
    plain = re.sub(r"[^a-z0-9]", "", bare.removesuffix("_2")) + repeated
    for pattern, site in _SITES:
        for side in ("l", "r") if "~" in pattern else ("",):
            words = pattern.replace("~", f"(?:{side}|{'left' if side == 'l' else 'right'})")
            if re.fullmatch(words, plain):
                return _on_side(site, side.upper())
    return None


def _on_side(site: Site, side: str) -> Site:
    """A site of the table on the side "L" or "R"."""
    joints = tuple(joint.replace("~", side) for joint in site.joints)
    return site._replace(segment=site.segment.replace("~", side), joints=joints, side=side)
