"""The logical window: the segments wanted, and those on their paths to the reference segment."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from workbench.model.arrays import Bools
from workbench.model.body import Body, Topology

__all__ = ["logical_window", "walk"]


def walk(body: Body | Topology, reference: int) -> list[tuple[int, int, int, bool]]:
    """The tree walked depth first from the reference segment: (to, came from, joint, upward) for
    each step.

    Upward is True where the step goes from a joint's distal segment to its proximal one. What hangs
    behind a step is the run of steps that follows it.
    """
    children: list[list[int]] = [[] for _ in body.segments]
    for child, parent in enumerate(body.parent[1:].tolist(), start=1):
        children[parent].append(child)
    steps: list[tuple[int, int, int, bool]] = []
    todo = [(reference, -1)]
    while todo:
        at, came = todo.pop()
        if came >= 0:
            upward = int(body.parent[came]) == at
            steps.append((at, came, (came if upward else at) - 1, upward))
        parent = int(body.parent[at])
        near = ([parent] if parent >= 0 else []) + children[at]
        todo += [(n, at) for n in reversed(near) if n != came]
    return steps


def logical_window(body: Body, segments: Iterable[str] | None, reference: int) -> Bools:
    """(N,) True for the named segments, the reference segment and all between them; None is the
    whole body.

    Source: Badler, O'Rourke & Toltzis 1979, the logical window (their Fig. 5). InputError for an
    unknown segment.
    """
    if segments is None:
        return np.ones(len(body.segments), dtype=np.bool_)
    came = {to: at for to, at, _, _ in walk(body, reference)}
    shown = np.zeros(len(body.segments), dtype=np.bool_)
    shown[reference] = True
    for name in segments:
        at = body.segment(name)
        while at != reference:
            shown[at] = True
            at = came[at]
    return shown
