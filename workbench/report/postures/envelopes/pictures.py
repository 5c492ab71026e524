"""The pictures of a reach envelope in a report: one that can be turned, with the person in place,
and its sections."""

from __future__ import annotations

from typing import Any

from markupsafe import Markup

from workbench.draw.envelopes.sections import envelope_sections
from workbench.draw.envelopes.solid import envelope_image, turnable_envelope
from workbench.draw.lines.svg import compacted
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.web.snippet import picture_address
from workbench.model.envelope import Envelope
from workbench.model.result import PosturesFound
from workbench.report.turnable import PageViews

__all__ = ["envelope_pictures"]

_PARTS = 5
"""How many obstacles are named."""


def envelope_pictures(
    result: PosturesFound, envelope: Envelope, views: PageViews
) -> dict[str, Any]:
    """The place of the turnable picture, sections as names and SVG, what the obstacles take that
    take most (part and litres), and how many others take how many litres.

    views: the pictures of the page; one is added.
    """
    person = next(person for person in result.people if person.name == envelope.person)
    environment = result.environment
    title = f"Reach envelope of {envelope.person}, {envelope.limb}"
    scene = Scene((SceneBody(person.placed, 0),), environment, (), title)
    caption = f"{title} in the posture of the first case"
    if envelope.obstacles:
        caption += "; blue where the limb comes clear, red where obstacles stop it short"
    shown = turnable_envelope(envelope, person.placed, environment, name=person.name)
    place = views.place(
        views.add(shown),
        still=picture_address(envelope_image(envelope, scene, "corner")),
        alt=f"{title}, corner view",
        caption=caption,
    )
    sections = [
        (name, Markup(compacted(svg)))
        for name, svg in envelope_sections(envelope, environment=environment)
    ]
    litres = [(part, 1000 * lost) for part, lost in envelope.lost_to.items()]
    named = [row for row in litres if row[0]][:_PARTS]
    return {
        "place": place,
        "main": sections[:2],
        "rest": sections[2:],
        "taken": named,
        "others": len(litres) - len(named),
        "by_others": sum(lost for _, lost in litres) - sum(lost for _, lost in named),
    }
