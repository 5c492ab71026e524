"""Map the bones of an unknown skeleton to the segments of a body.

Some bones are found by their names: hips, head, and upper arms, forearms, hands, thighs, shanks and
feet of both sides. The names are those of the CMU conversions, ASF, Biovision, MotionBuilder, Mixamo,
Biped, Unreal, Poser and MakeHuman, and the mnemonics of the segments. A prefix that nearly all bones
share is left out. The others are found by the tree: the upper torso is the bone
where arms and neck branch, and central torso, neck and shoulders lie on the paths between.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence

from workbench.errors import InputError, one_of
from workbench.model.motion import Bones

__all__ = ["bone_map"]

_SIDED = {
    "UA": ("arm", "upperarm", "uparm", "humerus", "shldr", "shoulder"),
    "LA": ("forearm", "lowerarm", "loarm", "radius", "elbow"),
    "HN": ("hand", "wrist"),
    "UL": ("upleg", "thigh", "upperleg", "femur", "hip"),
    "LL": ("leg", "calf", "shin", "lowerleg", "lowleg", "tibia", "knee"),
    "F": ("foot", "ankle"),
}
"""Usual names of bones by segment, the commonest first; the side stands before or after them."""
_MIDDLE = {"LT": ("hips", "pelvis", "hip", "root", "spinebase"), "H": ("head",)}
_SHARED = 0.8
"""Share of the bones whose names begin with the same word before it is a prefix."""
_OPTIONAL = {"LHN", "RHN", "LF", "RF", "H"}
"""Segments that may have no bone."""
_MNEMONICS = {"LT", "H"} | {side + limb for limb in _SIDED for side in "LR"}
_SEGMENTS = ("LT", "CT", "UT", "N", "H", *(s + limb for s in "LR" for limb in ("SM", *_SIDED)))
_PREFIX = re.compile(r"[^:_|.\- ]+[:_|.\- ]+(?=.)")


def bone_map(bones: Bones, given: Mapping[str, str] | None = None) -> dict[str, str]:
    """Find the bone of each segment that has one.

    Parameters
    ----------
    given
        Bones by segment, which take precedence over the usual names.

    Returns
    -------
    dict
        Names of bones by mnemonics of segments.

    Raises
    ------
    InputError
        If a limb is not found, or a given segment or bone does not exist. The message lists those
        that do.
    """
    given = dict(given or {})
    for segment, bone in given.items():
        if segment not in _SEGMENTS:
            raise InputError(
                f"{bones.file}: no segment {segment!r} (a line is 'SEGMENT: BONE'); {one_of(segment, _SEGMENTS)}"
            )
        if bone not in bones.names:
            raise InputError(
                f"{bones.file}: segment {segment}: no bone {bone!r}; {one_of(bone, bones.names)}"
            )
    found = _by_usual_names(bones) | given
    limbs = [side + limb for limb in _SIDED for side in "LR"]
    missing = [s for s in ("LT", *limbs) if s not in _OPTIONAL and s not in found]
    if missing:
        raise InputError(
            f"{bones.file}: no bone is known for segment {', '.join(missing)}: name them (map: "
            f"{{{missing[0]}: BONE}} in a study, or --names FILE with lines such as '{missing[0]}: BONE'); "
            f"the bones are {', '.join(bones.names[:60])}"
        )
    return _by_tree(bones, found) | found


def _by_usual_names(bones: Bones) -> dict[str, str]:
    """The bones of hips, head and limbs by segment."""
    own = {name for name in bones.names if name in _MNEMONICS}
    if own >= _MNEMONICS - _OPTIONAL:  # as the workbench writes them
        return {name: name for name in own}
    bare = _without_prefix(bones.names)
    plain = {_plain(b): name for b, name in zip(bare[::-1], bones.names[::-1], strict=True)}
    found = {
        segment: next((plain[word] for word in usual if word in plain), None)
        for segment, usual in _MIDDLE.items()
    }
    for side, words in (("L", ("left", "l")), ("R", ("right", "r"))):
        for limb, usual in _SIDED.items():
            forms = (
                form for word in words for name in usual for form in (word + name, name + word)
            )
            known = [plain[form] for form in forms if form in plain]
            if limb in ("HN", "F"):  # a wrist carries a hand, an ankle a foot
                known.sort(key=bones.names.index)
            found[side + limb] = known[0] if known else None
    return {segment: name for segment, name in found.items() if name}


def _without_prefix(names: Sequence[str]) -> list[str]:
    """The names without the beginnings, up to a colon, an underscore and the like, that nearly all
    of them share, such as `Character1_`."""
    bare = list(names)
    while True:
        begins = Counter(found[0] for name in bare if (found := _PREFIX.match(name)))
        prefix, count = begins.most_common(1)[0] if begins else ("", 0)
        if count < max(2, _SHARED * len(bare)):
            return bare
        bare = [name.removeprefix(prefix) for name in bare]


def _plain(name: str) -> str:
    """Lower-case letters and digits, without a prefix up to a colon and the usual first words."""
    bare = re.sub(r"[^a-z0-9]", "", name.rsplit(":", 1)[-1].lower())
    return re.sub(r"^(mixamorig|bip0?1|bip|def|jbip[clr]?)(?=.)", "", bare) or bare


def _by_tree(bones: Bones, found: dict[str, str]) -> dict[str, str]:
    """The bones of trunk, shoulders and neck by segment, which lie between the named ones."""
    arms = {side: _path_from_root(bones, found[side + "UA"]) for side in "LR"}
    shared = [a for a, b in zip(arms["L"], arms["R"], strict=False) if a == b]
    segments: dict[str, int | None] = _trunk_bones(bones.names.index(found["LT"]), shared)
    for side, arm in arms.items():
        shoulder = arm[len(shared) : -1]
        segments[side + "SM"] = shoulder[-1] if shoulder else None
    if "H" in found:
        segments["N"] = _neck_bone(_path_from_root(bones, found["H"]), shared)
    return {segment: bones.names[bone] for segment, bone in segments.items() if bone is not None}


def _trunk_bones(hips: int, shared: list[int]) -> dict[str, int | None]:
    """The bones of central and upper torso, of the path from the root that both arms share."""
    trunk = shared[shared.index(hips) + 1 :] if hips in shared else shared[-1:]
    half_way = trunk[len(trunk) // 2 - 1] if len(trunk) > 1 else None
    return {"CT": half_way, "UT": trunk[-1] if trunk else None}


def _neck_bone(head: list[int], shared: list[int]) -> int | None:
    """The first bone of the path to the head that is not on the path to the arms."""
    branch = max([k for k, bone in enumerate(head) if bone in shared], default=-1)
    neck = head[branch + 1 : -1]
    return neck[0] if neck else None


def _path_from_root(bones: Bones, name: str) -> list[int]:
    """The bones from the root to a bone, with both."""
    path = []
    bone = bones.names.index(name)
    while bone >= 0:
        path.append(bone)
        bone = int(bones.parent[bone])
    return path[::-1]
