"""How far a run is that asks many people: the pass that it is at, what is done of it, and the time left
of all passes together.

Of the pass that is at hand the time left is told by how fast it goes since its first people were done:
before that processes start and compile. What is ahead takes as long as a pass of its kind has taken;
where none was, by its weight, what all passes so far and the rest of this one take by theirs. The time
left never rises: where it would have to rise to more than twice as much as was told, none is told until
it does not.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

__all__ = ["ASKING", "BODIES", "CHANGE", "LAST", "MAP", "USUAL_CHANGES", "Count", "Passes"]

Say = Callable[[str], None]
Count = Callable[[float, int], None]
"""Called with how much is done, and of how many."""
BODIES, ASKING, CHANGE, MAP, LAST = "bodies", "asking", "change", "map", "last"
_WEIGHTS = {BODIES: 0.1, ASKING: 1.0, CHANGE: 0.2, MAP: 0.3, LAST: 0.2}
"""What a pass takes: fitting the bodies, asking everybody, asking again with a change, a map of a part,
and what follows (who is shown, pictures, the page). In runs of a car, a console and a light aircraft all
that follows the asking took 0.35 to 0.8 of it."""
USUAL_CHANGES = 2
"""Changes that are tried where none are asked for: up to five, but most runs find no more that gain."""
FIRST_ESTIMATE = 2.0
"""Time [s] after which it is told how long it will take."""
_KNOWN = 0.05
"""The share of a pass by which it tells how long it takes."""


class Passes:
    """The passes of one run.

    Parameters
    ----------
    say
        Called with a line: the pass, what is done of it, the time left.
    ahead
        The passes in their order; what does not come is left out when a later one begins.
    clock
        The time [s].
    """

    def __init__(
        self, say: Say, ahead: Sequence[str], *, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._say = say
        self._ahead = [*ahead]
        self._clock = clock
        self._begun = self._since = clock()
        self._behind: list[tuple[str, float]] = []
        self._now = ""
        self._first: tuple[float, float] | None = None
        self._left = math.inf

    def begin(self, kind: str, words: str) -> Count:
        """Begin a pass of some kind, in words ("asking everybody"). What is returned is called with how
        many people are done."""
        now = self._clock()
        if self._now:
            self._behind.append((self._now, now - self._since))
        self._now = kind
        self._since = now
        self._first = None
        if kind in self._ahead:
            del self._ahead[: self._ahead.index(kind) + 1]

        def tell(done: float, total: int) -> None:
            left = self._time_left(done / total if total else 1.0)
            self._say(f"{words}: {math.floor(done + 1e-6)} of {total} people{left}")

        return tell

    def _time_left(self, share: float) -> str:
        """ ", 40 s left" with a share of the pass done; "" where that is not known."""
        now = self._clock()
        if share > 0.0 and self._first is None:
            self._first = now, share
        own = self._own_left(now, share)
        if own is None or now - self._begun < FIRST_ESTIMATE or self._now == BODIES:
            return ""
        took = dict(self._behind)
        spent = sum(took for _, took in self._behind) + now - self._since + own
        unit = spent / (sum(_WEIGHTS[kind] for kind, _ in self._behind) + _WEIGHTS[self._now])
        left = own + sum(took.get(kind, unit * _WEIGHTS[kind]) for kind in self._ahead)
        if left > 2.0 * self._left + 5.0:
            return ""
        self._left = min(self._left, left)
        return (
            f", {self._left:.0f} s left"
            if self._left < 120
            else f", {self._left / 60:.0f} min left"
        )

    def _own_left(self, now: float, share: float) -> float | None:
        """The time left [s] of the pass at hand with a share of it done, None where that is not known."""
        if self._first is not None and share - self._first[1] > _KNOWN:
            return (now - self._first[0]) / (share - self._first[1]) * (1.0 - share)
        before = [took for kind, took in self._behind if kind == self._now]
        return before[-1] * (1.0 - share) if before else None
