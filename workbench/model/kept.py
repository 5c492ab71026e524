"""What is made once of a body, or of the topology that bodies share, and kept with it."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

from workbench.model.arrays import Ints
from workbench.model.body import KEPT, Body, Topology

__all__ = ["kept_by_row", "kept_with_body", "kept_with_topology"]

P = ParamSpec("P")
T = TypeVar("T")
_WHOLES = "wholes"
"""Where it is kept with rows of a body what each thing that is kept with them was taken from, by its
identity: it is kept as long as they are."""


def kept_with_body(
    function: Callable[Concatenate[Body, P], T],
) -> Callable[Concatenate[Body, P], T]:
    """Keep what a function makes of a body for as long as the body itself is kept.

    Further arguments are hashable and given by place. What is made of shared fields alone is better
    kept by the topology.
    """

    @wraps(function)
    def call(body: Body, /, *args: P.args, **options: P.kwargs) -> T:
        assert not options
        return _kept(body, function, body, args)

    return call


def kept_by_row(
    take: Callable[[T, Ints], T],
) -> Callable[[Callable[Concatenate[Body, P], T]], Callable[Concatenate[Body, P], T]]:
    """Keep what a function makes of a body with a row for each of its rows: rows of the body are
    served from what is made of the body that they were taken from.

    Parameters
    ----------
    take
        Takes rows (B,) of what the function makes.
    """

    def decorated(
        function: Callable[Concatenate[Body, P], T],
    ) -> Callable[Concatenate[Body, P], T]:
        plain: Callable[..., T] = function

        def made(body: Body, *args: Any) -> T:
            wholes = body.__dict__[KEPT].setdefault(_WHOLES, {})
            own = tuple(wholes.get(id(arg), arg) for arg in args)
            unknown = [hasattr(of, "rows") and of is arg for of, arg in zip(own, args, strict=True)]
            if body.source is None or any(unknown):
                return plain(body, *args)
            whole, rows = body.source
            original = _kept(whole, made, whole, own)
            found = take(original, rows)
            wholes[id(found)] = original
            return found

        @wraps(function)
        def call(body: Body, /, *args: P.args, **options: P.kwargs) -> T:
            assert not options
            return _kept(body, made, body, args)

        return call

    return decorated


def kept_with_topology(
    function: Callable[Concatenate[Body, P], T],
) -> Callable[Concatenate[Body, P], T]:
    """Keep what a function makes of the shared fields of a body for as long as its topology is kept.

    The function reads no row of the body. Further arguments are hashable and given by place.
    """

    @wraps(function)
    def call(body: Body, /, *args: P.args, **options: P.kwargs) -> T:
        assert not options
        return _kept(body.topology, function, body, args)

    return call


def _kept(
    keeper: Body | Topology,
    function: Callable[..., T],
    body: Body,
    args: tuple[Any, ...],
) -> T:
    kept = keeper.__dict__.setdefault(KEPT, {})
    key = (function, args)
    if key not in kept:
        kept[key] = function(body, *args)
    return kept[key]
