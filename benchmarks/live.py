"""CPU time of the live bench's answers: a joint turned, a hand brought to a point, a seat moved, and
the verdicts of all cases.

    python benchmarks/live.py [study] [body]

The people of the study take another body where one is named, in the same postures.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

import workbench as wb
from workbench.study.bench.answers import answer, judged, near_pairs
from workbench.study.bench.edits import Edit, LimbTarget, reached, seated, turned
from workbench.study.bench.placing import placed_people
from workbench.study.bench.state import OpenStudy, open_study

ROUNDS = 40


def cpu_of(function: Callable[[int], object], rounds: int = ROUNDS) -> str:
    """Median and 95th percentile of the CPU time of a function in this thread, in ms."""
    function(0)
    times = []
    for number in range(1, rounds + 1):
        begin = time.thread_time()
        function(number)
        times.append(1e3 * (time.thread_time() - begin))
    return f"{np.median(times):7.2f} ms, 95th percentile {np.quantile(times, 0.95):7.2f}"


def measure(opened: OpenStudy) -> None:
    """Print the times of one study."""
    start = opened.start
    person = start.people[0].role
    placement = placed_people(opened, start)
    before = answer(placement)
    tip = before.people[0].tips["right hand"]

    def answered(edit: Edit) -> None:
        near_pairs(answer(placed_people(opened, edit.arrangement, before=placement), before))

    def turn(number: int) -> None:
        answered(turned(opened, placement, person, "RE", 0, 60.0 + number % 20))

    def knee(number: int) -> None:
        answered(turned(opened, placement, person, "RK", 0, 60.0 + number % 20))

    def hand(number: int) -> None:
        goal = tip + 0.02 * np.array([0.0, np.sin(number), np.cos(number)])
        answered(reached(opened, placement, person, LimbTarget("right hand", tuple(goal))))

    def seat(number: int) -> None:
        answered(seated(opened, start, person, 0.001 * (number % 20), 0.0))

    def everything(number: int) -> None:
        near_pairs(answer(placed_people(opened, start)))

    print(f"everybody anew        {cpu_of(everything)}")
    print(f"an elbow turned       {cpu_of(turn)}")
    print(f"a knee turned         {cpu_of(knee)}")
    print(f"a hand to a point     {cpu_of(hand)}")
    if opened.seat(0) is not None:
        print(f"a seat moved          {cpu_of(seat)}")
    print(f"verdicts of all cases {cpu_of(lambda number: judged(opened, start), 5)}")


def main() -> None:
    """Measure the study and the body that are named."""
    study = wb.load_study(sys.argv[1] if len(sys.argv) > 1 else "trainer_clearance")
    if len(sys.argv) > 2:
        body = wb.load_body(sys.argv[2])
        study = replace(study, roles=tuple(replace(role, body=body) for role in study.roles))
    opened = open_study(study)
    spheres = [len(opened.body(row).sphere_names) for row in range(len(study.roles))]
    print(f"{study.name}: {len(spheres)} people of {spheres} spheres")
    measure(opened)


if __name__ == "__main__":
    main()
