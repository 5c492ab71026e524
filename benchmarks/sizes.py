"""How fast and how surely people become bodies: python benchmarks/sizes.py [people]

CPU seconds of this process; the goals stand beside the figures. Sources: ANSUR II as figures, seed 1.
"""

from __future__ import annotations

import sys
from time import process_time

import numpy as np

import workbench as wb
from workbench.files.populations import load_population_model
from workbench.shape.measure import MEASURES, measure
from workbench.shape.scale import scale

THIRTEEN = ("stature", "sitting_height", "bideltoid_breadth", "buttock_knee_length", "knee_height_sitting",
            "popliteal_height", "hip_breadth", "thigh_clearance", "shoulder_elbow_length", "radiale_stylion_length",
            "hand_length", "foot_length", "chest_depth")  # fmt: skip


def main(people: int) -> None:
    """Print one table."""
    body = wb.load_body("bubbleman")
    drawn = wb.draw_people(load_population_model("ansur2"), people, seed=1, men=0.5)
    rows = [{n: float(drawn.measures[i, drawn.names.index(n)]) for n in THIRTEEN} for i in range(people)]
    began = process_time()
    scale(body, rows[0])
    first = process_time() - began
    worst, failed, began = [], [], process_time()
    for row in rows:
        try:
            made = scale(body, row)
        except wb.InputError as error:
            failed.append(str(error))
            continue
        worst.append(max(abs(value - row[name]) for name, value in measure(made, THIRTEEN).items()))
    each = (process_time() - began) / people
    began = process_time()
    for _ in range(20):
        measure(body)
    taken = (process_time() - began) / 20
    print(f"{'first body (its shapes worked out)':<44}{first * 1e3:8.1f} ms")
    print(f"{'one person to 13 measures, checked':<44}{each * 1e3:8.1f} ms   goal 10")
    print(f"{'6,068 people, one core':<44}{each * 6068:8.1f} s    goal 120 (60 on two)")
    print(f"{f'{len(MEASURES)} measures of a body':<44}{taken * 1e3:8.1f} ms   goal 5")
    print(f"{'largest miss on a given measure':<44}{1e3 * float(np.max(worst)):8.5f} mm   goal 1")
    print(f"{'people refused':<44}{len(failed):8d} of {people}")
    for line in failed[:5]:
        print("   ", line)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 500)
