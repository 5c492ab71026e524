"""Read any motion file as what it holds, by its ending and header."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from workbench.errors import InputError, UsageError, one_of
from workbench.files.motions.bvh import bone_batches
from workbench.files.motions.laban import read_score
from workbench.files.motions.markers import read_c3d, read_trc
from workbench.files.motions.number_rows import ALL_FRAMES, FrameRange
from workbench.files.motions.opensim import Coordinates, coordinate_batches
from workbench.files.motions.tables import read_angle_table, segment_batches, table_kind
from workbench.files.schema import error_at
from workbench.files.yaml_text import read_yaml
from workbench.model.body import Body
from workbench.model.laban import Score
from workbench.model.motion import Bones, Markers, SegmentTrack
from workbench.model.poses import Poses

__all__ = ["MOTIONS", "Recorded", "load_names", "read_motion"]

MOTIONS = (".csv", ".bvh", ".trc", ".c3d", ".mot", ".sto", ".laban")
"""Endings of motion files."""
Recorded = tuple[Poses, tuple[str, ...]] | Bones | Markers | Coordinates | SegmentTrack | Score


def read_motion(
    path: str | Path,
    body: Body,
    *,
    up: str | None = None,
    metres: float | None = None,
    names: Mapping[str, str] | None = None,
    keep: FrameRange = ALL_FRAMES,
) -> Iterator[Recorded]:
    """Read a motion file, in batches of frames if its format allows (bones, coordinates, segments).

    `workbench.study.motions` turns what it holds into poses of a body.

    Parameters
    ----------
    path
        The file.
    body
        The body whose joint angles a table holds.
    up
        Upward axis of a BVH or marker file; if None it is found from the markers.
    metres
        One unit of a BVH or marker file [m]; if None it is as the file states.
    names
        The usual names of an OpenSim file's columns; bones and markers are named later.
    keep
        The frames that are wanted.

    Raises
    ------
    UsageError
        If `up` or `metres` does not belong to the format.
    InputError
        If the ending is unknown, or for any error in the file.
    """
    source = Path(path)
    ending = source.suffix.lower()
    if (up is not None or metres is not None) and ending not in (".bvh", ".trc", ".c3d"):
        raise UsageError(
            f"{source}: up and unit are for BVH and marker files; {ending or 'this'} says its own axes "
            "and units"
        )
    if names and ending in (".csv", ".laban"):
        raise UsageError(
            f"{source}: names are for bones, markers and coordinates, not for {ending} files"
        )
    if ending == ".csv" and table_kind(source) == "segments":
        yield from segment_batches(source, keep=keep)
    elif ending == ".csv":
        yield read_angle_table(source, body, keep=keep)
    elif ending == ".bvh":
        yield from bone_batches(source, keep=keep)
    elif ending in (".mot", ".sto"):
        yield from coordinate_batches(source, names=names, keep=keep)
    elif ending == ".laban":
        yield read_score(source)
    elif ending in (".trc", ".c3d"):
        read = read_trc if ending == ".trc" else read_c3d
        yield read(source, up=up, metres=metres, keep=keep)
    else:
        raise InputError(
            f"{source}: {ending or 'no ending'} is no motion format; {one_of(ending, MOTIONS)}"
        )


def load_names(path: str | Path) -> dict[str, str]:
    """Read a YAML file with the same lines as `map` of a motion in a study.

    Returns
    -------
    dict
        Bones by segment, or usual names of markers or coordinates by those of the motion file, ""
        for one that is left out.

    Raises
    ------
    InputError
        With line and column, if it is no mapping of texts.
    """
    document = read_yaml(path)
    if not isinstance(document.value, dict):
        raise InputError(error_at(document, (), "lines such as 'LUA: lhumerus' are needed"))
    names = {str(key): value for key, value in document.value.items()}
    wrong = [key for key, value in names.items() if not isinstance(value, str)]
    if wrong:
        raise InputError(
            [error_at(document, (key,), "a name is needed, in quotes") for key in wrong]
        )
    return names
