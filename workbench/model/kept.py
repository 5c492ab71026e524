"""What is made once of a body, or of the topology that bodies share, and kept with it."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

from workbench.model.body import KEPT, Body, Topology

__all__ = ["kept_with_body", "kept_with_topology"]

P = ParamSpec("P")
T = TypeVar("T")


def kept_with_body(
    function: Callable[Concatenate[Body, P], T],
) -> Callable[Concatenate[Body, P], T]:
    """Keep what a function makes of a body for as long as the body itself is kept.

    Further arguments are hashable and given by place. What is made of shared fields alone is better
    kept by the topology.
    """

    @wraps(function)
    def call(body: Body, /, *args: P.args, **options: P.kwargs) -> T:
        return _kept(body, function, body, *args, **options)

    return call


def kept_with_topology(
    function: Callable[Concatenate[Body, P], T],
) -> Callable[Concatenate[Body, P], T]:
    """Keep what a function makes of the shared fields of a body for as long as its topology is kept.

    The function reads no row of the body. Further arguments are hashable and given by place.
    """

    @wraps(function)
    def call(body: Body, /, *args: P.args, **options: P.kwargs) -> T:
        return _kept(body.topology, function, body, *args, **options)

    return call


def _kept(
    keeper: Body | Topology,
    function: Callable[Concatenate[Body, P], T],
    body: Body,
    /,
    *args: P.args,
    **options: P.kwargs,
) -> T:
    kept = keeper.__dict__.setdefault(KEPT, {})
    key = (function, args)
    if key not in kept:
        kept[key] = function(body, *args, **options)
    found: T = kept[key]
    return found
