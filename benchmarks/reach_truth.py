"""How many reaches that are said to be kept by an obstacle are false, by an independent judge.

    python -m benchmarks.reach_truth [--places trainer,compact_car] [--details coarse,medium,fine]
        [--hands "left hand,right hand"] [--people 20] [--deeper 0.1] [--most 200] [--seed 1]
        [--out FILE.json]

A line for each place, level of detail and hand, and one for each reach that is called kept though
there is a way. --deeper moves the targets forward into the panel [m]; --most bounds how many are
judged of each line; --out writes all that were judged, with the angles of the ways found.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from dataclasses import asdict
from pathlib import Path

from tests.reach_truth import HANDS, REAL, SHIPPED, seats_of, study_of, tally_of

__all__ = ["main"]


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--places", default=",".join([*SHIPPED, *REAL]))
    parser.add_argument("--details", default="coarse,medium,fine")
    parser.add_argument("--hands", default=",".join(HANDS))
    parser.add_argument("--people", type=int, default=20)
    parser.add_argument("--deeper", type=float, default=0.0)
    parser.add_argument("--most", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path)
    return parser.parse_args()


def main() -> None:
    """Print a line for each place, level of detail and hand, and the false ones."""
    options = _options()
    rows = []
    folder = Path(tempfile.mkdtemp())
    for name in options.places.split(","):
        for detail in options.details.split(","):
            seats = seats_of(name, study_of(name, folder), detail, options.people)
            for hand in options.hands.split(","):
                tally = tally_of(
                    seats, hand, deeper=options.deeper, most=options.most, seed=options.seed
                )
                print(tally, flush=True)
                for row in tally.rows:
                    if row.attempt >= 0:
                        print(f"  false: {row}", flush=True)
                rows += tally.rows
                if options.out is not None:
                    options.out.write_text(json.dumps([asdict(row) for row in rows], indent=1))


if __name__ == "__main__":
    main()
