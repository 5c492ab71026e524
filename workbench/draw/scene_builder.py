"""Build the scene that shows a body, an environment, a mesh, a study or a result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.body.forward import place
from workbench.draw.result_scene import result_source
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.source import Source, split_names
from workbench.draw.study_scene import study_source
from workbench.errors import InputError, UsageError, one_of
from workbench.files.bare_mesh import read_bare
from workbench.files.body.bodies import load_body
from workbench.files.catalogue import is_there, names
from workbench.files.environments import load_environment
from workbench.files.kinds import is_mesh, is_result, kind_of
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.files.study.reader import load_study
from workbench.model.person import Person
from workbench.model.posing import join_poses

__all__ = ["build_source", "mesh_source", "scene_of", "source_kind"]


def scene_of(source: str, *, posture: str | None = None, case: str | None = None) -> Scene:
    """Build the scene of a body in a posture, of an environment, or of a case of a study.

    See `build_source` for the arguments.
    """
    return build_source(source, poses=posture, case=case).scene


def build_source(
    source: str, *, poses: str | None = None, case: str | None = None, study: str | None = None
) -> Source:
    """Build what is to be drawn of a body, an environment, a mesh, a study or a result.

    Parameters
    ----------
    source
        A path, or a name of the catalogue.
    poses
        Postures of a body, with commas between. If None: standing, or the body's first posture.
    case
        Cases of a study, with commas between. If None: the first case, or all cases of a study
        whose poses are a motion.
    study
        Of a result: the file of its study, or its name; sought by its content if None.

    Raises
    ------
    InputError
        If a file or a name does not exist or cannot be read.
    UsageError
        If a case or a posture does not exist, or does not suit the kind of source.
    """
    kind = source_kind(source)
    if kind == "mesh":
        return mesh_source((source,))
    _check_choice(source, kind, poses, case)
    if study is not None and kind != "result":
        raise UsageError(f"{source} is no result: --study names the study of a result")
    if kind == "result":
        return result_source(Path(source), case, study)
    if kind == "environment":
        environment = load_environment(source)
        return Source(Scene((), environment, (), environment.name, environment.description))
    if kind == "body":
        return _body_source(source, poses)
    loaded = load_study(source)
    if loaded.crowd is not None:
        raise InputError(
            f"{source} is about many people and has no case to draw; run it: its report shows the hardest"
        )
    return study_source(loaded, case)


def mesh_source(
    sources: Sequence[str],
    *,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> Source:
    """Build what is to be drawn of mesh files; what is assumed of them is noted. Arguments and
    errors as of `read_bare`."""
    bare = read_bare(sources, length=length, up=up, forward=forward)
    notes = [f"assumed: {words}" for words in bare.assumed]
    if bare.assumed:
        notes.append("state what is wrong by --units, --up and --forward")
    scene = Scene((), bare.environment, (), bare.environment.name)
    return Source(scene, notes=tuple(notes))


def _check_choice(source: str, kind: str, poses: str | None, case: str | None) -> None:
    """Refuse postures unless the source is a body, and cases unless it is a study or a result."""
    has_cases = kind in ("study", "result")
    article = "an" if kind[0] in "aeiou" else "a"
    if poses is not None and kind != "body":
        hint = ", --case for studies" if has_cases else ""
        raise UsageError(f"{source} is {article} {kind}: --pose is for bodies{hint}")
    if case is not None and not has_cases:
        hint = ", --pose for bodies" if kind == "body" else ""
        raise UsageError(f"{source} is {article} {kind}: --case is for studies{hint}")


def _body_source(source: str, poses: str | None) -> Source:
    """Build a body in postures; several are a motion with a second from each to the next."""
    body = load_body(source)
    path = posture_path(source)
    if path is None:
        raise InputError(f"body {body.name} names no postures file")
    file, _ = load_postures(path, body)
    default = "standing" if "standing" in file.postures else next(iter(file.postures))
    chosen = (default,) if poses is None else split_names(poses)
    joined = join_poses([posture_pose(body, file, name) for name in chosen])
    if len(chosen) > 1:
        joined = replace(joined, time=np.arange(len(chosen), dtype=np.float64))
    person = Person(body.name, body, joined)
    scene = Scene((SceneBody(place(body, joined), 0),), None, (), body.name, ", ".join(chosen))
    return Source(scene, chosen, (body.name,), (person,), len(chosen) > 1)


def source_kind(source: str) -> str:
    """Return body, environment, mesh, study or result for a path or a name of the catalogue.

    Raises
    ------
    InputError
        If it is anything else.
    """
    path = Path(source)
    if is_there(path):
        kind = "result" if is_result(path) else kind_of(path)
        if kind in ("body", "environment", "mesh", "study", "result"):
            return kind
        raise InputError(
            f"{source}: a body, an environment, a mesh, a study or a result is needed (got {kind})"
        )
    if is_mesh(source):
        return "mesh"
    catalogue = {
        "body": names("bodies"),
        "environment": names("environments", "environment.yaml"),
        "study": names("studies"),
    }
    for kind, listed in catalogue.items():
        if source in listed:
            return kind
    every = [name for listed in catalogue.values() for name in listed]
    raise InputError(f"nothing is called {source!r}; {one_of(source, every)}")
