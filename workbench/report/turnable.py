"""The turnable pictures of a page, and links that make one look at a place."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from markupsafe import Markup, escape

from workbench.draw.camera import Camera, standard_view
from workbench.draw.disks import disks
from workbench.draw.hidden import seen_through, shining_part
from workbench.draw.scene import Mark, Scene
from workbench.draw.web.packing import Packing
from workbench.draw.web.snippet import picture_address, place_html
from workbench.draw.web.views import WebView
from workbench.files.results.result import FindingRow, VerdictRow

__all__ = [
    "CLOSE",
    "CloseUp",
    "Look",
    "PageViews",
    "close_up",
    "look",
    "still_picture",
]

CLOSE = 340
"""Width and height of a close-up [pixels]."""
_CLOSE_COLOURS = 192
_AROUND = 0.22
"""How much a close-up shows on each side of its point [m]."""
CloseUp = Callable[[FindingRow], str]
"""What draws a finding that has a place, as an address that holds the picture."""


@dataclass(frozen=True)
class Look:
    """A place to look at in a view of the page; view -1: in none."""

    view: int = -1
    at: str = ""
    """Coordinates [mm] with spaces between."""
    time: str = ""
    """[ms] in a motion, "" in a posture."""
    said: str = ""
    """What stands below the view then; the words of the link where it is ""."""

    def link(self, words: str) -> Markup:
        """The words, as a link that makes the view look there where there is one."""
        if self.view < 0:
            return escape(words)
        more = Markup(' data-time="{}"').format(self.time) if self.time else Markup("")
        if self.said:
            more += Markup(' data-said="{}"').format(self.said)
        return Markup('<a class="look" href="#view-{}" data-at="{}"{}>{}</a>').format(
            self.view, self.at, more, words
        )


@dataclass(eq=False)
class PageViews:
    """The views of a page as its sections are made, and the cases that they show.

    One of them is the lead, which stands large at the top of the page: the view of the case
    `wanted`, or the first one that is placed where none is wanted.
    """

    packing: Packing = field(default_factory=Packing)
    wanted: tuple[str, str] | None = None
    """The row and the case of the lead."""
    lead: Markup = field(default=Markup(""))
    """The place of the lead, once it is known."""
    _cases: dict[tuple[str, str], int] = field(default_factory=dict)
    _close_ups: dict[int, CloseUp] = field(default_factory=dict)

    def add(
        self, view: WebView, *, case: str = "", row: str = "", near: CloseUp | None = None
    ) -> int:
        """Add a view, of a case where one is named; returns its index.

        near: draws close-ups of what is found in it.
        """
        index = self.packing.add(view)
        if case:
            self._cases[row, case] = index
        if near is not None:
            self._close_ups[index] = near
        return index

    def place(self, index: int, *, still: str, alt: str, caption: str) -> Markup:
        """The place of a view on the page, see `place_html`; for the lead a link to the top, where
        it stands."""
        html = Markup(place_html(index, still=still, alt=alt, caption=caption))
        first = self.wanted is None or self._cases.get(self.wanted) == index
        if self.lead or not first:
            return html
        self.lead = html
        return Markup(
            '<p class="soft">Its picture is <a href="#view-{}">at the top</a>.</p>'
        ).format(index)

    def of_case(self, case: str, row: str = "") -> int:
        """The view of a case or a motion, -1 where there is none."""
        return self._cases.get((row, case), -1)

    def of_verdict(self, verdict: VerdictRow) -> Look:
        """Where the worst finding of a verdict is; nowhere where it passed or has no place."""
        worst = verdict.worst
        if worst is None or worst.point_mm is None or verdict.passed:
            return Look()
        return look(self._view(verdict, worst), worst.point_mm, worst.time_ms)

    def close_up(self, verdict: VerdictRow) -> str:
        """The address of a picture of where the worst finding of a verdict is, "" where it has no
        place."""
        worst = verdict.worst
        if worst is None or worst.point_mm is None:
            return ""
        near = self._close_ups.get(self._view(verdict, worst))
        return near(worst) if near is not None else ""

    def _view(self, verdict: VerdictRow, worst: FindingRow) -> int:
        """The view that shows a finding, -1 where there is none."""
        names = [(verdict.row or "", worst.case), ("", verdict.motion or "")]
        return next((self._cases[name] for name in names if name in self._cases), -1)


def look(view: int, point: Sequence[float], time: float | None = None, *, said: str = "") -> Look:
    """A place [mm] in a view, and when [ms]; nowhere where it is not finite.

    said: what stands below the view then, the words of the link where it is "".
    """
    if view < 0 or not all(map(math.isfinite, point)):
        return Look()
    when = "" if time is None or not math.isfinite(time) else f"{time:.3f}"
    return Look(view, " ".join(f"{value + 0.0:.1f}" for value in point), when, said)


def still_picture(scene: Scene, camera: Camera) -> str:
    """Draw a scene and return the picture as an address that holds it, in few colours."""
    return picture_address(disks(scene, camera, mode="shaded"))


def close_up(scene: Scene, point: Sequence[float], label: str, *, struck: str = "") -> str:
    """Draw what is around a point, from the side from which the gap there shows best.

    Parameters
    ----------
    scene
        People and environment; its marks are left out.
    point
        (3,) [mm].
    label
        What stands beside the point.
    struck
        What is met there, with the number of its polygon or without. A part shines through the
        body; other parts that stand before the point are see-through.

    Returns
    -------
    str
        An address that holds the picture.
    """
    at = np.array(point) / 1000.0
    spheres = scene.spheres
    nearest = int(np.argmin(np.linalg.norm(spheres.centre - at, axis=1) - spheres.radius))
    way = at - spheres.centre[nearest]
    box = np.array([at - _AROUND, at + _AROUND])
    cameras = [
        standard_view(name, box, width=CLOSE, height=CLOSE, margin=0.0)
        for name in ("front", "left", "top", "corner")
    ]
    camera = min(cameras, key=lambda one: round(abs(float(one.toward @ way)), 6))
    x, y, z = at.tolist()
    marked = replace(scene, marks=(Mark((x, y, z), label),))
    part = struck.split(",")[0]
    known = scene.environment is not None and part in scene.environment.parts
    marked, _ = seen_through(marked, camera, [at], kept=[part])
    picture = shining_part(marked, camera, part) if known else disks(marked, camera, mode="shaded")
    return picture_address(picture, colours=_CLOSE_COLOURS)
