"""Which bone of a strange skeleton is which segment: by the usual names of a dozen bones, the rest
by the tree.

Known by name: the hips, the head, and upper arms, forearms, hands, thighs, shanks and feet of both
sides, as the CMU conversions, Biovision, MotionBuilder, Mixamo, Biped, Unreal, Poser and MakeHuman
write them. The upper torso is the bone where arms and neck part; central torso, neck and shoulder
masses lie on the paths between.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from workbench.errors import InputError, one_of
from workbench.model.motion import Bones

__all__ = ["bone_map"]

_SIDED = {
    "UA": ("arm", "upperarm", "uparm", "shldr", "shoulder"),
    "LA": ("forearm", "lowerarm", "loarm", "elbow"),
    "HN": ("hand", "wrist"),
    "UL": ("upleg", "thigh", "upperleg", "hip"),
    "LL": ("leg", "calf", "shin", "lowerleg", "lowleg", "knee"),
    "F": ("foot", "ankle"),
}
_MIDDLE = {"LT": ("hips", "pelvis", "hip", "root"), "H": ("head",)}
_OPTIONAL = {"LHN", "RHN", "LF", "RF", "H"}


def bone_map(bones: Bones, given: Mapping[str, str] | None = None) -> dict[str, str]:
    """The bone of each segment that has one, by mnemonic.

    given: bones by segment, which go before what the names say. InputError where limbs are not
    found (the names that are there are listed) or a given name is unknown.
    """
    given = dict(given or {})
    for segment, bone in given.items():
        if bone not in bones.names:
            raise InputError(
                f"{bones.file}: segment {segment}: no bone {bone!r}; {one_of(bone, bones.names)}"
            )
    plain = {_plain(name): name for name in reversed(bones.names)}
    found = {segment: name for segment, usual in _MIDDLE.items() if (name := _first(plain, usual))}
    for side, words in (("L", ("left", "l")), ("R", ("right", "r"))):
        for limb, usual in _SIDED.items():
            name = _first(
                plain, [form for word in words for u in usual for form in (word + u, u + word)]
            )
            if name:
                found[side + limb] = name
    found |= given
    needed = [
        s for s in ("LT", *(side + limb for limb in _SIDED for side in "LR")) if s not in _OPTIONAL
    ]
    missing = [segment for segment in needed if segment not in found]
    if missing:
        raise InputError(
            f"{bones.file}: no bone is known for segment {', '.join(missing)}: name them (map: "
            f"{{{missing[0]}: BONE}}); the bones are {', '.join(bones.names[:60])}"
        )
    return _between(bones, found)


def _plain(name: str) -> str:
    """Lower case letters and digits, without what stands before a colon and the usual first
    words."""
    bare = re.sub(r"[^a-z0-9]", "", name.rsplit(":", 1)[-1].lower())
    return re.sub(r"^(mixamorig|bip0?1|bip|def|jbip[clr]?)(?=.)", "", bare) or bare


def _first(plain: Mapping[str, str], usual: tuple[str, ...] | list[str]) -> str | None:
    return next((plain[word] for word in usual if word in plain), None)


def _between(bones: Bones, found: dict[str, str]) -> dict[str, str]:
    """The map with the bones of the trunk, neck and shoulders that lie between the named ones in
    the tree."""
    index = {name: k for k, name in enumerate(bones.names)}

    def up(name: str) -> list[int]:
        path = []
        k = index[name]
        while k >= 0:
            path.append(k)
            k = int(bones.parent[k])
        return path[::-1]

    arms = [up(found["LUA"]), up(found["RUA"])]
    hips = index[found["LT"]]
    shared = [a for a, b in zip(*arms, strict=False) if a == b]
    trunk = shared[shared.index(hips) + 1 :] if hips in shared else shared[-1:]
    names: dict[str, list[int]] = {
        "CT": trunk[len(trunk) // 2 - 1 : len(trunk) // 2] if len(trunk) > 1 else [],
        "UT": trunk[-1:],
    }
    for side, arm in zip("LR", arms, strict=True):
        names[side + "SM"] = arm[len(shared) : -1][-1:]
    if "H" in found:
        path = up(found["H"])
        neck = path[max([k for k, b in enumerate(path) if b in shared], default=-1) + 1 : -1]
        names["N"] = neck[:1]
    return {s: bones.names[b[0]] for s, b in names.items() if b} | found
