"""Any motion file as what it holds: poses, bones, markers, coordinates, segments or a score; by
ending and header."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from workbench.errors import InputError, UsageError, one_of
from workbench.files.motions.bvh import bone_pieces
from workbench.files.motions.laban import read_score
from workbench.files.motions.markers import read_c3d, read_trc
from workbench.files.motions.number_rows import ALL, Pick
from workbench.files.motions.opensim import Coordinates, coordinate_pieces
from workbench.files.motions.tables import read_angle_table, segment_pieces, table_kind
from workbench.model.body import Body
from workbench.model.laban import Score
from workbench.model.motion import Bones, Markers, SegmentTrack
from workbench.model.poses import Poses

__all__ = ["MOTIONS", "Recorded", "read_motion"]

MOTIONS = (".csv", ".bvh", ".trc", ".c3d", ".mot", ".sto", ".laban")
Recorded = tuple[Poses, tuple[str, ...]] | Bones | Markers | Coordinates | SegmentTrack | Score


def read_motion(
    path: str | Path, body: Body, *, up: str | None = None, keep: Pick = ALL
) -> Iterator[Recorded]:
    """Read a motion file, some frames at a time where its form allows (bones, coordinates, single
    segments); what it holds is then made poses of a body by `workbench.study.motions`.

    up: the upward axis of a marker file, found from the markers where None. UsageError where `up`
    does not belong to the format; InputError for an unknown ending and for every fault of the file.
    """
    source = Path(path)
    ending = source.suffix.lower()
    if up is not None and ending not in (".bvh", ".trc", ".c3d"):
        raise UsageError(
            f"{source}: up is for BVH and marker files; {ending or 'this'} says its own axes"
        )
    if ending == ".csv" and table_kind(source) == "segments":
        yield from segment_pieces(source, keep=keep)
    elif ending == ".csv":
        yield read_angle_table(source, body, keep=keep)
    elif ending == ".bvh":
        yield from bone_pieces(source, keep=keep)
    elif ending in (".mot", ".sto"):
        yield from coordinate_pieces(source, keep=keep)
    elif ending == ".laban":
        yield read_score(source)
    elif ending in (".trc", ".c3d"):
        yield (read_trc if ending == ".trc" else read_c3d)(source, up=up, keep=keep)
    else:
        raise InputError(
            f"{source}: {ending or 'no ending'} is no motion format; {one_of(ending, MOTIONS)}"
        )
