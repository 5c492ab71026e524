"""What a film of the bench shows, and how it is written: as `workbench render` does it, from where the
page looks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import cycle
from pathlib import Path

import numpy as np

from workbench.body.forward import place
from workbench.draw.camera import Camera, look_at
from workbench.draw.display_options import DisplayOptions, parse_display_options
from workbench.draw.films.film import has_encoder
from workbench.draw.render import render
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.section_planes import SectionPlane
from workbench.draw.source import PEOPLE_COLOURS, Source
from workbench.errors import InputError
from workbench.model.environment import Environment
from workbench.model.person import Person
from workbench.study.bench.motions import playing
from workbench.study.bench.placing import Placement
from workbench.study.bench.state import OpenStudy

__all__ = ["FPS", "Film", "FilmView", "MotionClip", "film_ending"]

LONGEST_SIDE = 1280
SHORTEST_SIDE = 160
"""Pixels of a film each way, at most and at least."""
FPS = 25.0
"""Frames a second."""
LEAST_TIME = 4.0
"""Time [s] that a film of a motion takes at least: shorter ones are slowed down, as on the page."""
Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class FilmView:
    """How the page looks at what it shows.

    Parameters
    ----------
    eye, at
        (3,) [m] from where, and at which point.
    angle
        [rad] that is seen from bottom to top.
    width, height
        Pixels of the picture on the page.
    eyes
        The role through whose eyes it looks; "" for none.
    hidden
        The parts that are not shown.
    without
        The roles that are not shown.
    section
        The plane that opens the environment, None for none.
    """

    eye: tuple[float, float, float]
    at: tuple[float, float, float]
    angle: float
    width: int
    height: int
    eyes: str = ""
    hidden: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    section: SectionPlane | None = None


def film_ending() -> str:
    """Return the ending of a film that can be made here: MP4 where its encoder is installed."""
    return ".mp4" if has_encoder() else ".webp"


@dataclass(frozen=True, eq=False)
class MotionClip:
    """A film that can be drawn anywhere: what is drawn, how, and from where it is seen."""

    source: Source
    options: DisplayOptions
    camera: Camera | None

    def write(self, path: Path, progress: Progress) -> None:
        """Write the film; the file appears whole or not at all.

        Parameters
        ----------
        progress
            Called after each frame with the number of frames that are done, and of all; what it
            raises ends the film.
        """
        render(self.source, self.options, path, progress=progress, camera=self.camera)


@dataclass(frozen=True, eq=False)
class Film:
    """A film of a state: of a motion, or once round who is in a posture.

    Parameters
    ----------
    motion
        The case that is a motion, "" for the posture that is looked at.
    fps
        Frames a second.
    """

    opened: OpenStudy
    placement: Placement
    motion: str
    view: FilmView
    fps: float = FPS

    def take(self) -> MotionClip:
        """Return what is drawn, of the motions as the bench has read them.

        Raises
        ------
        InputError
            If nobody is shown, or a motion cannot be read.
        UsageError
            If it cannot be seen from there.
        """
        source = self._moving() if self.motion else self._still()
        options = self._options(source)
        camera = None
        if not self.view.eyes:
            camera = look_at(
                self.view.eye,
                self.view.at,
                field=self.view.angle,
                width=options.width,
                height=options.height,
            )
        return MotionClip(source, options, camera)

    def _options(self, source: Source) -> DisplayOptions:
        view = self.view
        scale = min(1.0, LONGEST_SIDE / max(view.width, view.height))
        width, height = (
            max(SHORTEST_SIDE, 2 * round(scale * side / 2)) for side in (view.width, view.height)
        )
        speed = 1.0
        if source.moving:
            clock = np.concatenate([person.poses.clock for person in source.persons])
            speed = min(1.0, max(float(np.ptp(clock)), 1e-3) / LEAST_TIME)
        options = parse_display_options(
            Path(f"film{film_ending()}"),
            view=f"eye:{view.eyes}" if view.eyes else None,
            size=f"{width}x{height}",
            angle=float(np.degrees(view.angle)),
            speed=speed,
            fps=self.fps,
        )
        return replace(options, cut=view.section)

    def _still(self) -> Source:
        """The people where they are, with their seats."""
        people = [
            (Person(one.state.role, one.body, one.poses), SceneBody(one.placed, 0, colour))
            for one, colour in zip(self.placement.people, cycle(PEOPLE_COLOURS), strict=False)
        ]
        return self._source(people, self.placement.parts.moved(), moving=False)

    def _moving(self) -> Source:
        """The people in their first frame, and their motions."""
        found = playing(self.opened, self.placement.arrangement, self.motion)
        people = []
        for one, colour in zip(found.motions, cycle(PEOPLE_COLOURS), strict=False):
            motion = replace(one.motion, time=one.motion.clock)
            first = place(one.body, replace(motion.rows(slice(1)), time=None))
            people.append((Person(one.person, one.body, motion), SceneBody(first, 0, colour)))
        return self._source(people, found.motions[0].cabin, moving=True)

    def _source(
        self, people: list[tuple[Person, SceneBody]], environment: Environment, *, moving: bool
    ) -> Source:
        """What is shown of people and of the environment.

        Raises
        ------
        InputError
            If nobody is shown.
        """
        shown = [row for row in people if row[0].name not in self.view.without]
        if not shown:
            raise InputError("a film shows people: show at least one of them")
        hidden = environment.hidden | np.isin(environment.parts, self.view.hidden)
        title = self.opened.study.title
        scene = Scene(
            tuple(body for _, body in shown), replace(environment, hidden=hidden), title=title
        )
        persons = tuple(person for person, _ in shown)
        names = tuple(person.name for person in persons)
        return Source(scene, (), names, persons, moving)
