"""Where on a body a marker sits, by its name: Plug-in-Gait, the OpenSim running set, and their near
relations.

A place is told as: segment, the joints between which its base lies, how far along, a shift of the
base in bodies of
1.75 m, and the direction in which the skin is met. `~` is the side (l or r); `out` is away from the
middle of the body. The last number is how far from there the marker may really sit [m].
"""

from __future__ import annotations

import re
from typing import NamedTuple

__all__ = ["Site", "marker_site"]


class Site(NamedTuple):
    """Where a marker sits: see the head of this file. side: "L", "R" or ""."""

    segment: str
    joints: tuple[str, ...]
    along: float
    shift: tuple[float, float, float]
    toward: str
    spread: float
    side: str = ""


_BONY = 0.012
_NEAR = 0.025
_LOOSE = 0.05
_NONE = (0.0, 0.0, 0.0)
_SITES: tuple[tuple[str, Site], ...] = (
    (r"~fhd|~frontalhead", Site("H", (), 0, (0.06, 0.06, 0.05), "front out", _NEAR)),
    (r"~bhd|~backhead", Site("H", (), 0, (-0.06, 0.06, 0.05), "back out", _NEAR)),
    (r"ariel|tophead|vertex", Site("H", (), 0, _NONE, "top", _NEAR)),
    (r"c7", Site("UT", ("NP",), 0, (0, 0, 0.02), "back", _NEAR)),
    (r"t10|t8", Site("UT", ("SP", "NP"), 0.25, _NONE, "back", _LOOSE)),
    (r"clav|ij|sternum", Site("UT", ("LC", "RC"), 0.5, (0, 0, 0.01), "front", _NEAR)),
    (r"strn|px", Site("UT", ("SP", "NP"), 0.35, _NONE, "front", _LOOSE)),
    (r"~sho|~acromi(um|on)|~shoulder|~shld", Site("~SM", ("~S",), 0, (0, 0, 0.03), "top", _NEAR)),
    (r"~fsh", Site("~SM", ("~S",), 0, _NONE, "front", _LOOSE)),
    (r"~bsh", Site("~SM", ("~S",), 0, _NONE, "back", _LOOSE)),
    (r"~upa|~bicep|~uparm", Site("~UA", ("~S", "~E"), 0.55, _NONE, "out", _LOOSE)),
    (r"~iel|~elbowmed(ial)?|~elbm", Site("~UA", ("~E",), 0, _NONE, "in", _BONY)),
    (r"~elb|~elbowlat(eral)?|~elbow", Site("~UA", ("~E",), 0, _NONE, "out", _BONY)),
    (r"~frm|~forearm|~fra", Site("~LA", ("~E", "~W"), 0.5, _NONE, "out", _LOOSE)),
    (r"~wra|~radius|~iwr", Site("~LA", ("~W",), 0, _NONE, "front", _NEAR)),
    (r"~wrb|~ulna|~owr", Site("~LA", ("~W",), 0, _NONE, "back", _NEAR)),
    (r"~wri|~wrist", Site("~LA", ("~W",), 0, _NONE, "out", _NEAR)),
    (r"~fin|~hand|~ohand|~wre", Site("~HN", (), 0, _NONE, "out", _LOOSE)),
    (r"~asis?|~fwt", Site("LT", ("~H",), 0, (0, 0.035, 0.085), "front", _NEAR)),
    (r"~psis?|~bwt", Site("LT", ("~H",), 0, (0, -0.04, 0.095), "back", _NEAR)),
    (
        r"vsac(ral)?|sacr(um|al)?|vsacral",
        Site("LT", ("LH", "RH"), 0.5, (0, 0, 0.09), "back", _NEAR),
    ),
    (r"~mwt|~iliaccrest|~iliac", Site("LT", ("~H",), 0, (0, 0, 0.13), "out", _NEAR)),
    (r"~gtr|~troch(anter)?", Site("~UL", ("~H",), 0, (0, 0, -0.01), "out", _NEAR)),
    (r"~hip", Site("~UL", ("~H", "~K"), 0.2, _NONE, "out", 0.10)),
    (r"~thi|~thigh|~thighupper|~thighrear", Site("~UL", ("~H", "~K"), 0.55, _NONE, "out", _LOOSE)),
    (r"~thighfront", Site("~UL", ("~H", "~K"), 0.5, _NONE, "front", _LOOSE)),
    (r"~kni|~kneemed(ial)?|~kne_2|~mknee", Site("~UL", ("~K",), 0, _NONE, "in", _BONY)),
    (r"~kne|~kneelat(eral)?|~knee", Site("~UL", ("~K",), 0, _NONE, "out", _BONY)),
    (r"~hf|~fibula", Site("~LL", ("~K", "~A"), 0.1, _NONE, "out", _NEAR)),
    (r"~tt|~tibialtuberosity", Site("~LL", ("~K", "~A"), 0.12, _NONE, "front", _NEAR)),
    (
        r"~tib|~sha|~shank|~shankupper|~shankfront|~shankrear|~shn",
        Site("~LL", ("~K", "~A"), 0.5, _NONE, "out", _LOOSE),
    ),
    (r"~anklemed(ial)?|~ank_2|~mank(le)?", Site("~LL", ("~A",), 0, _NONE, "in", _BONY)),
    (r"~ank|~anklelat(eral)?|~ankle", Site("~LL", ("~A",), 0, _NONE, "out", _BONY)),
    (r"~hee|~hel|~heel|~calc", Site("~F", (), 0, _NONE, "back", _NEAR)),
    (r"~toe|~mt2|~toetip", Site("~F", (), 0, _NONE, "front", _NEAR)),
    (r"~mt1|~toemed(ial)?", Site("~F", (), 0, (0.04, -0.01, 0), "in", _LOOSE)),
    (r"~mt5|~toelat(eral)?", Site("~F", (), 0, (0.03, 0.01, 0), "out", _LOOSE)),
)


def marker_site(name: str) -> Site | None:
    """The place of a marker by its name, None where the name is not known.

    What stands before a colon, dots, case and underscores do not matter, but `_2` of a repeated
    name does.
    """
    bare = name.rsplit(":", 1)[-1].lower()
    again = "_2" if bare.endswith("_2") else ""
    plain = re.sub(r"[^a-z0-9]", "", bare.removesuffix("_2")) + again
    for pattern, site in _SITES:
        for side in ("l", "r") if "~" in pattern else ("",):
            words = pattern.replace("~", f"(?:{side}|{'left' if side == 'l' else 'right'})")
            if re.fullmatch(words, plain):
                letter = side.upper()
                joints = tuple(j.replace("~", letter) for j in site.joints)
                return site._replace(
                    segment=site.segment.replace("~", letter), joints=joints, side=letter
                )
    return None
