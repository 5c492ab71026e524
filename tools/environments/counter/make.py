"""Build counter.obj, a service counter and a wheelchair in front of it: python
tools/environments/counter/make.py

Every length is in mm here; x is forward from where the planes of cushion and back meet, y left of the
middle of the wheelchair, z above the floor. Sizes of the wheelchair are within ISO 7176-5's of an
occupied manual wheelchair, those of the counter within ISO 21542's of one for sitting users: top 740
to 800 high, at least 700 free under it, 600 deep.
"""

from __future__ import annotations

import sys
from pathlib import Path

from manifold3d import Manifold

# where the solids of all environments are
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from solids import box, disc, hull, mirrored, sweep, union, write_obj

FOLDER = Path(__file__).resolve().parents[3] / "environments" / "counter"
SEAT = 520.0
"""Height of the cushion at the back."""
RISE = 0.07
"""Of the cushion toward the front, 4 degrees."""
LEAN = 0.14
"""Of the back, 8 degrees."""
TOP = 800.0
"""Height of the counter."""


def wheelchair() -> dict[str, Manifold]:
    """A manual wheelchair: cushion, back, and left and right of what there are two."""
    cushion = hull(
        [
            (x, y, SEAT + RISE * x - z)
            for x in (-20.0, 430.0)
            for y in (-215.0, 215.0)
            for z in (0.0, 60.0)
        ]
    )
    back = hull(
        [
            (-LEAN * z - t, y, SEAT + z)
            for z in (10.0, 420.0)
            for y in (-215.0, 215.0)
            for t in (0.0, 40.0)
        ]
    )
    left = {
        "wheel": disc((20.0, 275.0, 305.0), (0.0, 1.0, 0.0), 305.0, 25.0),
        "castor": disc((400.0, 215.0, 90.0), (0.0, 1.0, 0.0), 90.0, 30.0),
        "armrest": union(
            [
                box((20.0, 245.0, 690.0), (300.0, 285.0, 720.0)),
                box((150.0, 245.0, 620.0), (180.0, 270.0, 700.0)),
            ]
        ),
        "frame": sweep([(-60.0, 240.0, 440.0), (420.0, 240.0, 440.0), (600.0, 212.0, 155.0)], 12.0),
        "footplate": box((590.0, 40.0, 145.0), (790.0, 200.0, 160.0)),
    }
    named = {f"left_{name}": solid for name, solid in left.items()}
    named |= {f"right_{name}": mirrored(solid) for name, solid in left.items()}
    return {"cushion": cushion, "back": back} | named


def counter() -> dict[str, Manifold]:
    """The part of a service counter that is for sitting people, and what stands on it."""
    return {
        "floor": box((-1000.0, -1200.0, -40.0), (1600.0, 1200.0, 0.0)),
        "counter_top": box((460.0, -600.0, TOP - 40.0), (1060.0, 600.0, TOP)),
        "counter_front": box((1060.0, -600.0, 0.0), (1100.0, 600.0, TOP)),
        "card_terminal": box((640.0, -220.0, TOP), (800.0, -140.0, TOP + 60.0)),
        "bell": box((660.0, 140.0, TOP), (720.0, 200.0, TOP + 50.0)),
        "screen": box((1060.0, -600.0, TOP + 200.0), (1066.0, 600.0, TOP + 1000.0)),
        "high_counter": box((460.0, -1200.0, 0.0), (1100.0, -640.0, 1100.0)),
    }


def main() -> None:
    """Write counter.obj into a folder, environments/counter where none is given."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    title = "service counter with a wheelchair, made by make.py"
    write_obj(folder / "counter.obj", wheelchair() | counter(), title)


if __name__ == "__main__":
    main()
