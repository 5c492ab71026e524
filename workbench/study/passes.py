"""How far a run is that asks many people: the pass that it is at, what is done of it, and the time left
of all passes together.

What is left is told in units of the pass of asking, by weights of the passes that are ahead. These are
high, so that what is left falls short of the first estimate. With w of the work done after a time t,
and v of it ahead,

    left = t v / w,

but what is left of a pass is told by that pass alone once a part of it is done; and no more than was told before: the time left never rises. Where it would have to rise to more than
twice as much, none is told until it does not.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

__all__ = ["ASKING", "BODIES", "CHANGE", "LAST", "MAP", "Count", "Passes"]

Say = Callable[[str], None]
Count = Callable[[float, int], None]
"""Called with how much is done, and of how many."""
BODIES, ASKING, CHANGE, MAP, LAST = "bodies", "asking", "change", "map", "last"
_WEIGHTS = {BODIES: 0.1, ASKING: 1.0, CHANGE: 0.5, MAP: 0.3, LAST: 0.3}
"""What a pass takes: fitting the bodies, asking everybody, asking again with a change, a map of a part,
and what follows (who is shown, pictures, the page)."""
FIRST_ESTIMATE = 2.0
_LEAST_DONE = 0.05
"""Time [s] after which it is told how long it will take, and the share of the work that must be done:
to fit bodies tells nothing of how long the people are asked."""
_KNOWN = 0.1
"""The share of a pass by which it tells by itself how long it takes."""


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
        self._behind = 0.0
        self._now = 0.0
        self._left = math.inf

    def begin(self, kind: str, words: str) -> Count:
        """Begin a pass of some kind, in words ("asking everybody"). What is returned is called with how
        many people are done."""
        self._behind += self._now
        self._now = _WEIGHTS[kind]
        self._since = self._clock()
        if kind in self._ahead:
            del self._ahead[: self._ahead.index(kind) + 1]

        def tell(done: float, total: int) -> None:
            left = self._time_left(done / total if total else 1.0)
            self._say(f"{words}: {math.floor(done + 1e-6)} of {total} people{left}")

        return tell

    def _time_left(self, share: float) -> str:
        """ ", 40 s left" with a share of the pass done; "" where that is not known."""
        done = self._behind + share * self._now
        ahead = sum(_WEIGHTS[kind] for kind in self._ahead)
        left = (1.0 - share) * self._now
        now = self._clock()
        if now - self._begun < FIRST_ESTIMATE or done < _LEAST_DONE * (done + left + ahead):
            return ""
        rate = (now - self._begun) / done
        own = (now - self._since) / share * (1.0 - share) if share > _KNOWN else rate * left
        if own + rate * ahead > 2.0 * self._left + 5.0:
            return ""
        self._left = min(self._left, own + rate * ahead)
        return (
            f", {self._left:.0f} s left"
            if self._left < 120
            else f", {self._left / 60:.0f} min left"
        )
