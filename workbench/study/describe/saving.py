"""A description saved as an environment's file: written anew, or changed in the text that is
there."""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.errors import InputError
from workbench.files.catalogue import find
from workbench.files.environments import load_environment
from workbench.files.output_file import replaced, saving, write_errors, write_file
from workbench.files.study.reader import read_study
from workbench.files.study.saving import StudyText
from workbench.files.yaml_changes import Key, changed_text, yaml_text
from workbench.files.yaml_text import read_yaml
from workbench.model.environment import Environment
from workbench.study.describe.first_study import first_study, guesses_of
from workbench.study.describe.state import UNSURE, Description, OpenPlace

__all__ = [
    "FirstStudy",
    "ForeignFileError",
    "SavedPlace",
    "description_text",
    "next_commands",
    "people_study",
    "save_description",
    "save_first_study",
    "unfinished",
]

ORDER = (
    "environment",
    "description",
    "source",
    "licence",
    "length",
    "accepted",
    "meshes",
    "parts",
    "seats",
    "points",
    "controls",
    "adjustments",
    "instruments",
    "mirrors",
)
_FRAME = ("length", "up", "forward")
BESIDE = (".gltf",)
"""Meshes that are made of several files, which are not copied."""


class ForeignFileError(InputError):
    """A file is in the way that was not made here, or has changed since."""


@dataclass(frozen=True)
class FirstStudy:
    """A first study that was written: what was guessed in it, and its warnings."""

    guesses: tuple[str, ...]
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class SavedPlace:
    """A file as it was read or written: its text and what it says, and the warnings of what loads
    it."""

    text: StudyText
    says: Mapping[str, Any]
    warnings: tuple[str, ...] = ()


def description_text(description: Description, before: SavedPlace | None) -> str:
    """Return the text that says what a description says.

    Parameters
    ----------
    before
        A file whose comments, order and style stay, as far as it says the same; None for none.

    Raises
    ------
    InputError
        If the text cannot be changed so that it says this.
    """
    says = description.says
    if before is not None:
        return changed_text(before.text.text, says, notes=description.why, block=_in_block)
    known = dict.fromkeys([*ORDER, *says])
    ordered = {key: says[key] for key in known if says.get(key)}
    return yaml_text(ordered, description.why, _in_block)


def _in_block(key: Key) -> bool:
    """Whether a mapping or list is written line by line."""
    if key[0] == "meshes":
        return len(key) <= 2 or (len(key) == 3 and key[2] == "join")
    return len(key) == 1 or (len(key) == 2 and key[0] in ("seats", "adjustments"))


def save_description(
    opened: OpenPlace,
    description: Description,
    before: SavedPlace | None,
    *,
    to: Path | None = None,
    over: bool = False,
) -> SavedPlace:
    """Save a description, after the new text was read and found to be an environment.

    Parameters
    ----------
    before
        The file as it was opened or saved last, None where there is none yet.
    to
        Another file, whose text is the same; where the place was opened from, or is to be, if None.
    over
        Whether a file is replaced that was not made here or has changed since. The meshes are
        copied where the file is to be in another folder.

    Raises
    ------
    ForeignFileError
        If there is such a file.
    InputError
        If the folder cannot be written, the text says something else, or does not load; then
        nothing has changed.
    """
    path = (opened.target if to is None else to).resolve()
    with write_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    with saving(path):
        changed = opened.changed_meshes(len(description.says["meshes"]))
        if changed and not over:
            raise ForeignFileError(
                f"{', '.join(changed)} has changed on the disk since it was opened: what was picked "
                f"may be elsewhere"
            )
        if path.exists() and not over:
            if before is None or before.text.path != path:
                raise ForeignFileError(f"{path.name} is there already, and was not made here")
            if before.text.changed_on_disk():
                raise ForeignFileError(f"{path.name} has changed on the disk since it was opened")
        data = description_text(description, before).encode()
        _copy_meshes(opened, description, path.parent, over=over)
        environment = replaced(path, data, lambda partial: _loaded(partial, path.name))
    return SavedPlace(StudyText(path, data), description.says, environment.warnings)


def _loaded(partial: Path, name: str) -> Environment:
    """The environment of a file that is to have another name; InputError by that name."""
    try:
        return load_environment(partial)
    except InputError as error:
        lines = [problem.replace(str(partial), name) for problem in error.problems]
        raise InputError(lines) from None


def unfinished(opened: OpenPlace, description: Description) -> list[str]:
    """Sentences about what is begun and is not in the file, or is in it as a guess alone."""
    found = []
    for name, picks in description.picks.items():
        lacks = " and the ".join(picks.lacks)
        if name not in description.file.seats:
            found.append(f"seat {name} is not in the file: its {lacks} was not picked")
        elif lacks:
            found.append(
                f"seat {name} has the figures of before: its {lacks} is not picked again yet"
            )
    for row, mesh in enumerate(description.file.meshes):
        unsure = [
            key
            for key in _FRAME
            if description.why.get(("meshes", row, key), "").startswith(UNSURE)
        ]
        if unsure:
            found.append(f"{mesh.file}: {' and '.join(unsure)}: a guess that nobody confirmed")
    return found


def save_first_study(environment: str | Path, to: Path, *, people: int = 0) -> FirstStudy:
    """Write a first study of an environment: its file, or its name in the catalogue.

    people: as of `first_study`.

    Raises
    ------
    InputError
        If there is a file already, it cannot be written, or it does not load.
    """
    if to.exists():
        raise InputError(f"{to.name} is there already: name another file")
    source = str(environment)
    if Path(environment).exists():
        source = Path(os.path.relpath(Path(environment).resolve(), to.resolve().parent)).as_posix()
    room = load_environment(environment)
    text = first_study(room, source, people=people)
    write_file(to, text)
    place = find("environments", source, "environment.yaml", near=to.parent)
    study = read_study(read_yaml(to), to, {"study": to}, {place: room})
    return FirstStudy(tuple(guesses_of(text)), tuple(study.warnings))


def people_study(study: Path) -> Path:
    """Where the study of many people stands, beside a first study."""
    return study.with_stem(f"{study.stem}_people")


def next_commands(saved: Path) -> list[str]:
    """The commands that lead from an environment that was saved to studies of one and of many."""
    path = Path(os.path.relpath(saved))
    shown = path if ".." not in path.parts else saved
    study = shown.with_name("study.yaml")
    people = people_study(study)
    run = people if people.exists() or not study.exists() else study
    rows = [["new", str(shown), "--people", "100"], ["run", str(run)], ["live", str(study)]]
    if study.exists():
        del rows[0]
    return [shlex.join(["workbench", *row]) for row in rows]


def _copy_meshes(opened: OpenPlace, description: Description, folder: Path, *, over: bool) -> None:
    """Copy the meshes beside an environment that lie elsewhere than it says."""
    for mesh, raw in zip(description.says["meshes"], opened.meshes.raws, strict=False):
        source = Path(raw.file)
        copy = folder / mesh["file"]
        if copy.resolve() == source.resolve():
            continue
        if copy.exists() and copy.read_bytes() == source.read_bytes():
            continue
        if source.suffix.lower() in BESIDE:
            raise InputError(
                f"{source.name} is made of several files: save beside it, or move them yourself"
            )
        if copy.exists() and not over:
            raise ForeignFileError(f"{copy.name} is there already, and is another mesh")
        copy.parent.mkdir(parents=True, exist_ok=True)
        write_file(copy, source.read_bytes())
