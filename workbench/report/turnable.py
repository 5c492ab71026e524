"""The turnable pictures of a page, and links that make one look at a place."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from markupsafe import Markup, escape

from workbench.draw.camera import Camera
from workbench.draw.disks import disks
from workbench.draw.scene import Scene
from workbench.draw.web.packing import Packing
from workbench.draw.web.snippet import place_html
from workbench.draw.web.views import WebView
from workbench.files.results.result import VerdictRow

__all__ = ["Look", "PageViews", "look", "still_picture"]

_COLOURS = 160


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
    """The views of a page as its sections are made, and the cases that they show."""

    packing: Packing = field(default_factory=Packing)
    _cases: dict[tuple[str, str], int] = field(default_factory=dict)

    def add(self, view: WebView, *, case: str = "", row: str = "") -> int:
        """Add a view, of a case where one is named; returns its index."""
        index = self.packing.add(view)
        if case:
            self._cases[row, case] = index
        return index

    def place(self, index: int, *, still: str, alt: str, caption: str) -> Markup:
        """The place of a view on the page, see `place_html`."""
        return Markup(place_html(index, still=still, alt=alt, caption=caption))

    def of_verdict(self, verdict: VerdictRow) -> Look:
        """Where the worst finding of a verdict is; nowhere where it passed or has no place."""
        worst = verdict.worst
        if worst is None or worst.point_mm is None or verdict.passed:
            return Look()
        names = [(verdict.row or "", worst.case), ("", verdict.motion or "")]
        found = [self._cases[name] for name in names if name in self._cases]
        return look(found[0], worst.point_mm, worst.time_ms) if found else Look()


def look(view: int, point: Sequence[float], time: float | None = None, *, said: str = "") -> Look:
    """A place [mm] in a view, and when [ms]; nowhere where it is not finite.

    said: what stands below the view then, the words of the link where it is "".
    """
    if not all(map(math.isfinite, point)):
        return Look()
    when = "" if time is None or not math.isfinite(time) else f"{time:.3f}"
    return Look(view, " ".join(f"{value + 0.0:.1f}" for value in point), when, said)


def still_picture(scene: Scene, camera: Camera) -> str:
    """Draw a scene and return the picture as an address that holds it, in few colours."""
    out = io.BytesIO()
    disks(scene, camera).quantize(_COLOURS).save(out, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(out.getvalue()).decode("ascii")
