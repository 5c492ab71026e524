"""The turnable picture as a widget of a notebook, with a state that Python and browser share.

Python sends what stands still once, and the people whenever they change. What is hidden, chosen or
cut away goes both ways: an attribute that is set shows in every place of the widget, and what
somebody does in the picture can be read and observed here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

from workbench.draw.section_planes import parse_section_plane, side_name
from workbench.draw.source import PEOPLE_COLOURS
from workbench.draw.web.packing import Packing
from workbench.draw.web.snippet import WIDGET, script, style
from workbench.draw.web.views import WebBody, WebView, body_view
from workbench.errors import MissingPartError, UsageError, one_of
from workbench.model.arguments import argument_fault
from workbench.model.environment import Environment
from workbench.model.poses import Placed

try:
    from anywidget import AnyWidget
    from traitlets import Bytes, TraitType, observe, validate
except ImportError:
    raise MissingPartError(
        "a picture that Python moves needs anywidget: pip install 'bubbleman-workbench[notebook]'"
    ) from None

__all__ = ["LOOKS", "PictureWidget"]

LOOKS = ("left", "right", "front", "back", "top", "corner")
"""From where a picture can be looked at."""
_MOST_PEOPLE = 40
"""People that are shown at one time."""
_HEIGHT = (100, 4000)
"""Least and most height [pixels]."""
_ANYHOW = ""
"""What `look_from` says after the picture was turned by hand."""


def _as_list(value: Sequence[str], _: object) -> list[str]:
    return list(value)


class PictureWidget(AnyWidget):
    """A turnable picture in a notebook; `workbench.view` makes it.

    Every attribute can be set, and observed by `observe(function, "selected")` as of any widget. A
    wrong value is a UsageError and changes nothing.

    Parameters
    ----------
    views
        The pictures; one of them is shown.
    people, height
        As the attributes.
    fixed
        Why the people cannot be replaced, "" where they can.

    Attributes
    ----------
    people
        Placed, or a mapping of names to it: who is shown. Every pose is a person. None: the people
        of what is viewed.
    picture
        Index of the picture that is shown, of `titles`.
    look_from
        left, right, front, back, top or corner; "" after the picture was turned by hand.
    section
        The side that is cut away, and perhaps the place: "left", "left=0.3" [m], "left=300mm"; None
        for no section.
    hidden
        Names of parts and people that are not shown.
    see_through_walls
        Whether walls before a body are a veil.
    selected
        What was clicked: () for nothing, (part,), (person, segment) or (person, segment, sphere).
    height
        Of the picture [pixels].
    """

    _esm = script(WIDGET)
    _css = style() + (files("workbench.draw.web") / "widget.css").read_text(encoding="utf-8")
    _scene = Bytes(b"").tag(sync=True)
    _people = Bytes(b"").tag(sync=True)
    people = TraitType(None)
    picture = TraitType(0).tag(sync=True)
    look_from = TraitType("corner").tag(sync=True)
    section = TraitType(None).tag(sync=True)
    hidden = TraitType(()).tag(sync=True, to_json=_as_list)
    see_through_walls = TraitType(True).tag(sync=True)
    selected = TraitType(()).tag(sync=True, to_json=_as_list)
    height = TraitType(480).tag(sync=True)

    def __init__(
        self,
        views: Sequence[WebView],
        *,
        people: Placed | Mapping[str, Placed] | None = None,
        height: int = 480,
        fixed: str = "",
    ) -> None:
        packing = Packing()
        for one in views:
            packing.add(one)
        self._views = tuple(views)
        self._bodies: tuple[WebBody, ...] | None = None
        self._fixed = fixed
        super().__init__(
            _scene=packing.block(), people=people, look_from=views[0].look_from, height=height
        )

    def __repr__(self) -> str:
        return f"PictureWidget({self.titles[self.picture]})"

    @property
    def titles(self) -> tuple[str, ...]:
        """What the pictures show."""
        return tuple(one.title for one in self._views)

    @validate("people")
    def _check_people(self, proposal: dict[str, Any]) -> Placed | Mapping[str, Placed] | None:
        """Make the bodies of the people; they are sent when the value is set."""
        people = proposal["value"]
        _refuse(argument_fault("people", people, Placed | Mapping[str, Placed] | None))
        if people is not None and self._fixed:
            raise UsageError(f"people: {self._fixed}")
        self._bodies = None if people is None else tuple(_bodies(people))
        return dict(people) if isinstance(people, Mapping) else people

    @validate("picture")
    def _check_picture(self, proposal: dict[str, Any]) -> int:
        picture = proposal["value"]
        _refuse(argument_fault("picture", picture, int))
        if not 0 <= picture < len(self._views):
            shown = "; ".join(f"{k} {title}" for k, title in enumerate(self.titles))
            raise UsageError(f"picture: there is no picture {picture}; valid: {shown}")
        return int(picture)

    @validate("look_from")
    def _check_look_from(self, proposal: dict[str, Any]) -> str:
        look: str = proposal["value"]
        _refuse(argument_fault("look_from", look, str))
        if look not in (*LOOKS, _ANYHOW):
            raise UsageError(f"look_from: there is no view {look!r}; {one_of(look, LOOKS)}")
        return look

    @validate("section")
    def _check_section(self, proposal: dict[str, Any]) -> str | None:
        text: str | None = proposal["value"]
        _refuse(argument_fault("section", text, str | None))
        if text is None:
            return None
        plane = parse_section_plane(text, option="section")
        name = side_name(plane)
        return name if plane.at is None else f"{name}={round(plane.at, 4) + 0.0}"

    @validate("hidden")
    def _check_hidden(self, proposal: dict[str, Any]) -> tuple[str, ...]:
        names = proposal["value"]
        _refuse(argument_fault("hidden", names, Sequence[str]))
        known = [*self._part_names(), *(body.name for body in self._shown_bodies())]
        for name in names:
            if name not in known:
                raise UsageError(f"hidden: nothing here is called {name!r}; {one_of(name, known)}")
        return tuple(dict.fromkeys(names))

    @validate("see_through_walls")
    def _check_see_through_walls(self, proposal: dict[str, Any]) -> bool:
        _refuse(argument_fault("see_through_walls", proposal["value"], bool))
        return bool(proposal["value"])

    @validate("selected")
    def _check_selected(self, proposal: dict[str, Any]) -> tuple[str, ...]:
        names = proposal["value"]
        _refuse(argument_fault("selected", names, Sequence[str]))
        if len(names) == 1:
            _check_name("selected: a part", names[0], self._part_names())
        elif names:
            self._check_sphere(names)
        return tuple(names)

    @validate("height")
    def _check_height(self, proposal: dict[str, Any]) -> int:
        height = proposal["value"]
        _refuse(argument_fault("height", height, int))
        least, most = _HEIGHT
        if not least <= height <= most:
            raise UsageError(f"height: expected {least} to {most} pixels, got {height}")
        return int(height)

    @observe("people", "picture")
    def _take_people(self, _: object) -> None:
        """Send the people; what is no longer there is neither hidden nor chosen."""
        if self._bodies is None:
            self._people = b""
        else:
            packing = Packing()
            packing.add(WebView("", self._bodies))
            self._people = packing.block()
        known = {*self._part_names(), *(body.name for body in self._shown_bodies())}
        self.hidden = tuple(name for name in self.hidden if name in known)
        if self.selected and self.selected[0] not in known:
            self.selected = ()

    def _shown_bodies(self) -> tuple[WebBody, ...]:
        return self._views[self.picture].bodies if self._bodies is None else self._bodies

    def _part_names(self) -> tuple[str, ...]:
        """The parts of the picture that is shown."""
        place = self._views[self.picture].environment
        if isinstance(place, Environment):
            return tuple(
                name for name, gone in zip(place.parts, place.hidden, strict=True) if not gone
            )
        return () if place is None else place.names

    def _check_sphere(self, names: Sequence[str]) -> None:
        """UsageError unless these are a person, a segment and perhaps a sphere."""
        if len(names) > 3:
            raise UsageError(
                "selected: expected (), (part,), (person, segment) or (person, segment, sphere), "
                f"got {len(names)} names"
            )
        bodies = {body.name: body for body in self._shown_bodies()}
        body = bodies[_check_name("selected: a person", names[0], bodies)]
        _check_name(f"selected: a segment of {names[0]}", names[1], body.segments)
        if len(names) == 3:
            number = body.segments.index(names[1])
            rows = zip(body.segment, body.spheres, strict=True)
            inside = [sphere for segment, sphere in rows if segment == number and sphere]
            _check_name(f"selected: a sphere of {names[1]}", names[2], inside)


def _refuse(fault: str) -> None:
    if fault:
        raise UsageError(fault)


def _check_name(what: str, name: str, known: Mapping[str, object] | Sequence[str]) -> str:
    """Return a name that is known; UsageError for another."""
    if name not in known:
        raise UsageError(f"{what} was expected, got {name!r}; {one_of(name, known)}")
    return name


def _bodies(people: Placed | Mapping[str, Placed]) -> list[WebBody]:
    """The people as they are shown, each pose a person, in colours that take turns."""
    named = {people.body.name: people} if isinstance(people, Placed) else people
    count = sum(len(placed) for placed in named.values())
    if count > _MOST_PEOPLE:
        raise UsageError(f"people: expected {_MOST_PEOPLE} poses at most, got {count}")
    bodies: list[WebBody] = []
    for name, placed in named.items():
        for row in range(len(placed)):
            colour = PEOPLE_COLOURS[len(bodies) % len(PEOPLE_COLOURS)]
            called = name if len(placed) == 1 else f"{name} {row + 1}"
            bodies.append(body_view(placed, called, colour, frames=[row]))
    return bodies
