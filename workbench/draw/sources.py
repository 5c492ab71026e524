"""From the name of a body, an environment or a study to the scene that shows it."""

from __future__ import annotations

from pathlib import Path

from workbench.draw.scene import Scene, SceneBody
from workbench.errors import InputError, UsageError, one_of
from workbench.files.bodies import load_body
from workbench.files.catalogue import names
from workbench.files.environments import load_environment
from workbench.files.kinds import kind_of
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.files.studies import load_study
from workbench.solve.forward import place
from workbench.study.persons import sized
from workbench.study.placement import adjusted_environment, place_person

__all__ = ["PEOPLE_COLOURS", "scene_of"]

PEOPLE_COLOURS = ("warm", "blue", "green", "rose", "grey")


def scene_of(source: str, *, posture: str = "standing", case: str | None = None) -> Scene:
    """The scene of a body in a posture, of an environment, or of a case of a study.

    InputError for what is not there; UsageError for a case the study does not have.
    """
    kind = _kind(source)
    if kind == "environment":
        environment = load_environment(source)
        return Scene((), environment, (), environment.name, environment.description)
    if kind == "body":
        return _body_scene(source, posture)
    study, _ = sized(load_study(source))
    wanted = study.cases[0] if case is None else case
    if wanted not in study.cases:
        raise UsageError(f"study {study.name} has no case {wanted!r}; {one_of(wanted, study.cases)}")
    pose = study.cases.index(wanted)
    environment = adjusted_environment(study)
    bodies = tuple(
        SceneBody(place_person(person, environment), pose, PEOPLE_COLOURS[i % len(PEOPLE_COLOURS)])
        for i, person in enumerate(study.people)
    )
    return Scene(bodies, environment, (), study.title, wanted)


def _body_scene(source: str, posture: str) -> Scene:
    body = load_body(source)
    path = posture_path(source)
    if path is None:
        raise InputError(f"body {body.name} names no postures file")
    file, _ = load_postures(path, body)
    placed = place(body, posture_pose(body, file, posture))
    return Scene((SceneBody(placed, 0),), None, (), body.name, posture)


def _kind(source: str) -> str:
    """body, environment or study, of a path or a catalogue name."""
    path = Path(source)
    if path.exists():
        kind = kind_of(path)
        if kind in ("body", "environment", "study"):
            return kind
        raise InputError(f"{source}: a body, an environment or a study is needed (got {kind})")
    known = {"body": names("bodies"), "environment": names("environments", "environment.yaml"),
             "study": names("studies")}  # fmt: skip
    for kind, there in known.items():
        if source in there:
            return kind
    raise InputError(f"nothing is called {source!r}; {one_of(source, [n for row in known.values() for n in row])}")
