"""Find where a marker sits on a body by its name.

Known names are those of Plug-in-Gait, the OpenSim gait and running sets, and near relations.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

from workbench.errors import InputError, one_of
from workbench.model.motion import Markers

__all__ = ["USUAL_SPREAD", "Site", "marker_site", "named_sites"]


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
_PERSON = 6
"""Known markers from which on they are those of a person."""
_PREFIX = re.compile(r"[^_|.\- ]+[_|.\- ]+(?=.)")
"""What the name of a marker may begin with."""
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


def named_sites(markers: Markers, names: Mapping[str, str]) -> dict[str, Site]:
    """Return the sites of the markers that are known by their own or their given name.

    Parameters
    ----------
    markers
        The markers of one person; their names may have a prefix that six share.
    names
        The usual name of markers with unusual ones, "" to leave a marker out; "Bob:*" stands for
        all that begin so.

    Raises
    ------
    InputError
        If `names` has an unknown name, or markers of several people are there.
    """
    for name in names:
        if name not in markers.names and not _members(markers, name):
            raise InputError(f"{markers.file}: no marker {name!r}; {one_of(name, markers.names)}")
    names = {one: usual for name, usual in names.items() for one in _members(markers, name)} | {
        name: usual for name, usual in names.items() if name in markers.names
    }
    prefixes = _prefixes(markers, names)
    sites = {
        name: _named_site(markers, name, names, prefixes.get(name, "")) for name in markers.names
    }
    return {name: site for name, site in sites.items() if site is not None}


def _members(markers: Markers, name: str) -> list[str]:
    """The markers whose names begin as a name with a * at its end does."""
    begin = name.removesuffix("*")
    return [one for one in markers.names if begin != name and one.startswith(begin)]


def _prefixes(markers: Markers, names: Mapping[str, str]) -> dict[str, str]:
    """The prefix of each marker that is known without it, such as `Bob:` or `Bob_`.

    Refuses markers of several people.
    """
    found: dict[str, str] = {}
    for name in markers.names:
        prefix = name[: name.rfind(":") + 1]
        begin = _PREFIX.match(name)
        if not prefix and begin and marker_site(name) is None:
            prefix = begin[0]
        if name not in names and marker_site(name.removeprefix(prefix)) is not None:
            found[name] = prefix
    counts = Counter(found.values())
    people = [prefix for prefix, count in counts.items() if count >= _PERSON]
    if len(people) > 1:
        said = ", ".join(f"{prefix or 'no prefix'} ({counts[prefix]})" for prefix in people)
        other = next(prefix for prefix in people[::-1] if prefix)
        raise InputError(
            f"{markers.file}: markers of several people, by what their names begin with: {said}; leave out all "
            f'but one (map: {{"{other}*": ""}} in a study, or --names FILE with a line \'"{other}*": ""\')'
        )
    return {name: prefix for name, prefix in found.items() if prefix in people}


def _named_site(markers: Markers, name: str, names: Mapping[str, str], prefix: str) -> Site | None:
    """The site of a marker by its usual name; `names` has that of some, the others have a prefix."""
    usual = names.get(name, name.removeprefix(prefix))
    site = marker_site(usual) if usual else None
    if name in names and usual and site is None:
        raise InputError(
            f"{markers.file}: marker {name!r}: no usual marker is called {usual!r} (LASI, RKNE, C7, ...)"
        )
    return site
