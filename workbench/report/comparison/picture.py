"""The turnable picture of somebody who fits in one of two designs only."""

from __future__ import annotations

from html import escape

from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.draw.web.packing import Packing
from workbench.draw.web.views import scene_view
from workbench.model.comparison import Comparison, Judged
from workbench.model.figures import plain
from workbench.model.population import person_name
from workbench.model.population_found import ChangedPerson, Shown
from workbench.report.comparison.words import change_sentence, worst_missed
from workbench.report.population.words import (
    spare_words,
)
from workbench.report.states import TwoStates, two_states

__all__ = ["changed_picture", "person_to_show"]

_NAMES = ("before", "after")


def person_to_show(found: Comparison) -> tuple[int, str] | None:
    """Return the row of the first who gains, else of the first who loses, and the requirement that
    was, or is, missed by most; None where nobody changes or only one design asks for it."""
    for row in (*found.gained, *found.lost):
        name = worst_missed(found, row)
        if name in found.before.requirements and name in found.after.requirements:
            return row, name
    return None


def changed_picture(found: Comparison, seen: ChangedPerson, packing: Packing) -> str:
    """Return the place of the picture of somebody in both designs, and a sentence above it.

    Parameters
    ----------
    packing
        The pictures of the page; this one is added.
    """
    name = worst_missed(found, seen.row)
    pairs = ((found.before, seen.before), (found.after, seen.after))
    scenes = [_scene(judged, shown, name, seen.row) for judged, shown in pairs]
    who = found.before.labels[seen.row]
    title = f"{who}: {plain(name)}"
    place = two_states(
        TwoStates(
            views=(scene_view(scenes[0], [who]), scene_view(scenes[1], [who])),
            scenes=(scenes[0], scenes[1]),
            names=_NAMES,
            title=title,
            said=title,
            caption=f"{person_name(who)}, {plain(name)}: what is short or to spare in either design",
        ),
        packing,
    )
    return f'<p class="soft">{escape(change_sentence(found, seen.row))}</p>\n{place}\n'


def _scene(judged: Judged, shown: Shown, name: str, row: int) -> Scene:
    """Somebody in one design, with what is short or to spare where the requirement is."""
    margin = float(judged.margin[row, judged.requirements.index(name)])
    short = not bool(judged.met[row, judged.requirements.index(name)])
    unit = judged.unit(name)
    words = f"{unit.short(-margin)} short" if short else spare_words(margin, unit)
    marks: tuple[Mark, ...] = ()
    if shown.target is not None:
        marks = (Mark(shown.target, words, "missed" if short else "reach"),)
    return Scene((SceneBody(shown.placed, 0, "warm"),), shown.environment, marks, judged.title)
