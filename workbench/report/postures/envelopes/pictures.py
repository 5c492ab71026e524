"""The pictures of a reach envelope in a report: in the round over the person in place, and its
sections."""

from __future__ import annotations

from typing import Any

from markupsafe import Markup

from workbench.draw.envelopes.sections import envelope_sections
from workbench.draw.envelopes.solid import VIEWS, envelope_view
from workbench.draw.scene import Scene, SceneBody
from workbench.model.envelope import Envelope
from workbench.model.result import PosturesFound

__all__ = ["envelope_pictures"]

_PARTS = 5
"""How many obstacles are named."""


def envelope_pictures(result: PosturesFound, envelope: Envelope) -> dict[str, Any]:
    """Views and sections as names and SVG, and what the obstacles take that take most: part and
    litres."""
    person = next(person for person in result.people if person.name == envelope.person)
    environment = result.environment
    title = f"Reach envelope of {envelope.person}, {envelope.limb}"
    scene = Scene((SceneBody(person.placed, 0),), environment, (), title)
    views = [
        (view.replace("_", " "), Markup(envelope_view(envelope, scene, view))) for view in VIEWS
    ]
    sections = [
        (name, Markup(svg)) for name, svg in envelope_sections(envelope, environment=environment)
    ]
    taken = [(part, 1000 * litres) for part, litres in envelope.lost_to.items() if part][:_PARTS]
    return {"views": views, "main": sections[:2], "rest": sections[2:], "taken": taken}
