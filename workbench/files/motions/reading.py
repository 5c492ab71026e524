"""Any motion file as what it holds: poses, bones, markers, coordinates, segments or a score; by ending and header."""

from __future__ import annotations

from pathlib import Path

from workbench.errors import InputError, UsageError, one_of
from workbench.files.motions.bvh import read_bvh
from workbench.files.motions.laban import read_score
from workbench.files.motions.lines import ALL, Pick
from workbench.files.motions.markers import read_c3d, read_trc
from workbench.files.motions.opensim import Coordinates, read_coordinates
from workbench.files.motions.tables import read_angle_table, read_segment_table, table_kind
from workbench.model.body import Body
from workbench.model.laban import Score
from workbench.model.motion import Bones, Markers, SegmentTrack
from workbench.model.poses import Poses

__all__ = ["MOTIONS", "Recorded", "read_motion"]

MOTIONS = (".csv", ".bvh", ".trc", ".c3d", ".mot", ".sto", ".laban")
Recorded = tuple[Poses, tuple[str, ...]] | Bones | Markers | Coordinates | SegmentTrack | Score


def read_motion(path: str | Path, body: Body, *, up: str | None = None, keep: Pick = ALL) -> Recorded:
    """Read a motion file; what it holds is then made poses of a body by `workbench.study.motions`.

    up: the upward axis of a marker file, found from the markers where None. UsageError where `up` does not belong to
    the format; InputError for an unknown ending and for every fault of the file.
    """
    source = Path(path)
    ending = source.suffix.lower()
    if up is not None and ending not in (".bvh", ".trc", ".c3d"):
        raise UsageError(f"{source}: up is for BVH and marker files; {ending or 'this'} says its own axes")
    if ending == ".csv":
        return read_segment_table(source, keep=keep) if table_kind(source) == "segments" else \
            read_angle_table(source, body, keep=keep)  # fmt: skip
    if ending == ".bvh":
        return read_bvh(source, keep=keep)
    if ending in (".mot", ".sto"):
        return read_coordinates(source, keep=keep)
    if ending == ".laban":
        return read_score(source)
    if ending in (".trc", ".c3d"):
        return (read_trc if ending == ".trc" else read_c3d)(source, up=up, keep=keep)
    raise InputError(f"{source}: {ending or 'no ending'} is no motion format; {one_of(ending, MOTIONS)}")
