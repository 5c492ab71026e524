"""The turnable picture of two states of the same people or place, with a slider that wipes from the
one to the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from workbench.draw.web.packing import TENTH
from workbench.draw.web.place_mesh import paired_mesh
from workbench.draw.web.views import WebBody, WebPlace, WebView
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.environment import Environment

__all__ = ["compared_view"]


def compared_view(
    before: WebView, after: WebView, *, names: tuple[str, str], title: str
) -> WebView:
    """Return two pictures as one: what is alike in both once, all else in its own state.

    Parameters
    ----------
    before, after
        The pictures; two motions at the same times.
    names
        What the states are called.
    title
        What the picture shows.

    Raises
    ------
    InputError
        If the pictures are of motions at different times, or of places that are no environments.
    """
    if before.times != after.times:
        raise InputError(f"{title}: the two motions must be shown at the same times")
    marks = [
        replace(mark, state=state)
        for state, view in enumerate((before, after))
        for mark in view.marks
    ]
    return WebView(
        title,
        tuple(_bodies(before.bodies, after.bodies, names)),
        _place(before, after, names, title),
        tuple(marks),
        before.times,
        look_from=before.look_from,
        begin=before.begin,
        states=names,
    )


def _place(
    before: WebView, after: WebView, names: tuple[str, str], title: str
) -> Environment | WebPlace | None:
    """The place of both, in two states where it differs."""
    one = before.environment
    two = after.environment
    if one is two:
        return one
    if not (isinstance(one, Environment) and isinstance(two, Environment)):
        raise InputError(f"{title}: both pictures must show an environment, or none")
    place = paired_mesh(one, two)
    called = (
        name if state is None else f"{name}, {names[state]}"
        for name, state in zip(place.names, place.state, strict=True)
    )
    return replace(place, names=tuple(called))


def _bodies(
    before: Sequence[WebBody], after: Sequence[WebBody], names: tuple[str, str]
) -> Iterator[WebBody]:
    """The bodies of both; one that is alike in both once."""
    shared = [body for body in before if any(_is_alike(body, other) for other in after)]
    yield from shared
    for state, bodies in enumerate((before, after)):
        for body in bodies:
            if not any(_is_alike(body, one) for one in shared):
                yield replace(body, name=f"{body.name}, {names[state]}", state=state)


def _is_alike(one: WebBody, two: WebBody) -> bool:
    return (
        (one.name, one.colour, one.segments, one.failing, one.touching, one.ghost)
        == (two.name, two.colour, two.segments, two.failing, two.touching, two.ghost)
        and _is_near(one.centres, two.centres)
        and _is_near(one.radius, two.radius)
    )


def _is_near(one: Floats, two: Floats) -> bool:
    """Whether lengths [m] are the same as far as they are shown."""
    return one.shape == two.shape and bool(np.all(np.abs(one - two) < TENTH / 2))
