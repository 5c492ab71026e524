"""What limits somebody in a requirement: a noun, so that nothing has to be read out of its words.

Names come from files and may hold anything, commas and the word "at" included. They stand in fields
of their own, and words are made of these in one place.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from workbench.model.figures import tenths

__all__ = ["NO_REASON", "TOO_SHORT", "Kind", "Reason", "hider", "short_words"]

Kind = Literal[
    "",  # nothing limits
    "words",  # something of the seat, the eyes or the stance that has no name in a file
    "limb",  # the limb is too short
    "stop",  # the stop of a joint
    "segment",  # a segment of the body
    "near",  # a segment that is too near to a part or to another segment
    "part",  # a part is in the way
    "deep",  # a limb is where it should be, and its arm or leg too deep in something
    "own",  # the own body is
    "other",  # somebody else's is
    "beyond",  # eyes and head do not turn so far
    "outside",  # it is beside a mirror
    "reading",  # a limit of reading
    "cuts",  # the two cuts of a pillar
    "mirrored",  # panes mirror it
]


_LEADS = {
    "cuts": "its upper and its lower cut alone hide ",
    "mirrored": "mirrored by ",
}
"""How the words of some kinds begin."""


@dataclass(frozen=True)
class Reason:
    """What limits somebody in a requirement.

    kind: in which way. thing: the joint, part or segment by its name, else fixed words; of the cuts
    of a pillar their angles. at: of a segment that is too near, what it is too near to; of a limb that
    is too deep, what it is: "arm", "leg". foot: the
    foot that is limited, "" of none. share: of what is to be seen that the thing hides, 0 to 1; 0
    where it is not known or not told.
    """

    kind: Kind = ""
    thing: str = ""
    at: str = ""
    foot: str = ""
    share: float = 0.0

    def __bool__(self) -> bool:
        return self.kind != ""

    @property
    def part(self) -> str:
        """The part that is in the way, "" of every other kind."""
        return self.thing if self.kind in ("part", "deep") else ""

    @property
    def text(self) -> str:
        """In words, with names as in their files: "right knee at console", "left foot, the seat stops
        too far back", "left_stick hides 30 %"."""
        near = f" at {self.at}" if self.at and self.kind != "deep" else ""
        text = _LEADS.get(self.kind, "") + self.thing + near
        if self.share:
            share = f"{100 * self.share:.3g} %"
            text = f"{share} is {text}" if self.kind == "outside" else f"{text} hides {share}"
        return f"{self.foot}, {text}" if self.foot else text

    @property
    def why(self) -> str:
        """As a clause of its own: "canopy is in the way", "limited by right elbow (flexion)",
        "left_stick hides 30 %"; "" where nothing limits."""
        if not self or self.share or self.kind in ("cuts", "mirrored"):
            return self.text
        if self.kind in ("part", "own", "other") and not self.foot:
            return f"{'the ' if self.kind == 'own' else ''}{self.text} is in the way"
        if self.kind == "deep" and not self.foot:
            return f"on it the {self.at} is that much too deep in {self.text}"
        return f"{'it is' if self.kind == 'beyond' else 'limited by'} {self.text}"

    @property
    def clause(self) -> str:
        """The same at the end of a sentence: ", limited by right elbow (flexion)", "; canopy is in the
        way"."""
        why = self.why
        return f"{',' if why.startswith('limited by ') else ';'} {why}" if why else ""


def short_words(limb: str, control: str, miss: float, overlap: float, limit: Reason) -> str:
    """How far a limb stays from a control that it does not reach, and what keeps or limits it: "the
    right hand stays 8.7 mm short of flaps; canopy is in the way".

    miss, overlap: [m] how far it stays away, and how much deeper than allowed it is in something even
    there.
    """
    if limit.kind == "words":  # the thighs are too deep in the cushion
        miss, overlap = miss + overlap, 0.0
    if overlap > 0.0 and miss < SEEN:
        within = limit.text or "an obstacle"
        return f"the {limb} gets to {control} only {tenths(1e3 * overlap)} mm too deep in {within}"
    deep = (
        f", which it is {tenths(1e3 * overlap)} mm too deep in even there" if overlap > 0.0 else ""
    )
    return f"the {limb} stays {tenths(1e3 * miss)} mm short of {control}{limit.clause}{deep}"


SEEN = 5e-5
"""[m] What is smaller reads as 0.0 mm."""
NO_REASON = Reason()
TOO_SHORT = Reason("limb", "length of the limb")


def hider(name: str, parts: tuple[str, ...], share: float = 0.0) -> Reason:
    """What stands before something: a part, else "own ..." of the body that looks or somebody else's;
    share: that it hides, kept to a thousandth."""
    kind: Kind = "own" if name.startswith("own ") else "other"
    return (
        Reason("part" if name in parts else kind, name, share=round(share, 3))
        if name
        else NO_REASON
    )
