"""CPU time of the live bench's answers: a joint turned, a hand brought to a point, a seat or part
moved, and the verdicts of all cases; of a study with a population how its people at hand follow.

    python benchmarks/live.py [study] [body]

The people of the study take another body where one is named, in the same postures.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np

import workbench as wb
from workbench.live.following import Following
from workbench.live.looking import Colours, FieldWork
from workbench.live.server import SWITCH
from workbench.model.study import PeopleDrawn
from workbench.model.surroundings import Move
from workbench.study.bench.answers import answer, judged, near_pairs
from workbench.study.bench.crowd import AT_HAND
from workbench.study.bench.edits import Edit, seated, shifted
from workbench.study.bench.edits_joints import LimbTarget, reached, turned
from workbench.study.bench.placing import Placement, people_here, placed_people, sight_verdicts
from workbench.study.bench.state import OpenStudy, open_study
from workbench.threads import available_cores

ROUNDS = 40
FOLLOWED = {
    "trainer": {
        "a control": Move((), ("flaps",), (0.0, 0.0, 0.0)),
        "a control that is held": Move((), ("throttle",), (0.0, 0.0, 0.0)),
        "a lever with its control": Move(("flap_lever",), (), (0.0, 0.0, 0.0)),
        "the panel": Move(("instrument_panel",), (), (0.0, 0.0, 0.0)),
        "the canopy": Move(("canopy", "canopy_frame"), (), (0.0, 0.0, 0.0)),
    },
    "compact_car": {
        "a control": Move((), ("hazard_button",), (0.0, 0.0, 0.0)),
        "the panel": Move(("instrument_panel",), (), (0.0, 0.0, 0.0)),
        "the roof": Move(("roof_lining",), (), (0.0, 0.0, 0.0)),
    },
}
"""What is dragged in front of a population, by environment."""


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
    there = judged(opened, start).there
    placement = placed_people(opened, start, there=there)
    before = answer(placement)
    tip = before.people[0].tips["right hand"]

    def answered(edit: Edit) -> None:
        after = placed_people(opened, edit.arrangement, there=there, before=placement)
        near_pairs(answer(after, before))

    def turn(number: int) -> None:
        answered(turned(placement, person, "RE", 0, 60.0 + number % 20))

    def knee(number: int) -> None:
        answered(turned(placement, person, "RK", 0, 60.0 + number % 20))

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
    part = next(
        name
        for k, name in enumerate(opened.study.environment.parts)
        if not any(k in moving for moving in opened.movers)
    )

    def move(number: int) -> None:
        by = (0.0, 0.0, 0.001 * (1 + number % 20))
        answered(shifted(opened, start, Move((part,), (), by)))

    print(f"a part moved          {cpu_of(move)}")
    print(f"verdicts of all cases {cpu_of(lambda number: judged(opened, start), 5)}")
    measure_sight(opened, placement, part)


def measure_sight(opened: OpenStudy, placement: Placement, part: str) -> None:
    """Print the CPU time, of all threads, of what is seen: the field of the first person whose head
    turns, and the verdicts of sight while a part is dragged."""

    def all_threads(function: Callable[[int], object], rounds: int = 10) -> str:
        function(0)
        times = []
        for number in range(1, rounds + 1):
            begin = time.process_time()
            function(number)
            times.append(1e3 * (time.process_time() - begin))
        return f"{np.median(times):7.2f} ms, largest {max(times):7.2f}"

    person = placement.people[0].state.role
    colours: Colours = {}

    def head(number: int, fine: bool = False) -> None:
        toward = (float(np.cos(0.1 * number)), float(np.sin(0.1 * number)), -0.2)
        FieldWork(opened, placement, 0, person, toward, 60, fine, colours).made()

    def seen(number: int) -> None:
        state = shifted(opened, opened.start, Move((part,), (), (0.0, 0.0, 0.001 * (1 + number))))
        there = placed_people(opened, state.arrangement, before=placement)
        here = people_here(opened, there)
        list(sight_verdicts(opened, there.arrangement, here))

    print(f"a head turned         {all_threads(head)}")
    print(f"and counted finely    {all_threads(partial(head, fine=True))}")
    if not any(one.free for one in opened.start.people):
        print(f"sight, a part dragged {all_threads(seen)}")


def measure_people(opened: OpenStudy) -> None:
    """Print how long the people at hand take to follow: what is known at once, and with what must
    be searched for."""
    people = Following(opened)
    people.begin()
    crowd = people.crowd
    assert crowd is not None
    start = opened.start
    begin = time.process_time()
    for number in range(people.at_hand):
        people.settle(number, start, 0)
    settle = time.process_time() - begin
    person = placed_people(opened, start, there=judged(opened, start).there).people[crowd.row]
    begin = time.process_time()
    for number in range(people.at_hand):
        people.remember(number, (person.forward, person.up))
    remember = time.process_time() - begin
    count = crowd.at_hand
    print(f"{count} people settled {settle:.1f} s of CPU time, made ready {remember:.1f}")
    who = start.people[crowd.row].role
    generations = iter(range(1, 1000))

    def follow(name: str, state: Callable[[int], Edit], rounds: int) -> None:
        """Print the time of one step of a drag, the first one apart, and the CPU time of all
        threads."""
        rows = []
        for number in range(rounds):
            arrangement = state(number).arrangement
            generation = next(generations)
            row = []
            begin = time.perf_counter(), time.process_time()
            for search in (False, True):
                one = partial(
                    people.follow, arrangement=arrangement, generation=generation, search=search
                )
                for turn in people.turns:
                    list(pool.map(one, turn))
                row += [time.perf_counter() - begin[0], time.process_time() - begin[1]]
            rows.append(1e3 * np.array(row))
        first = rows[0]
        then = np.median(rows[1:], axis=0)
        print(
            f"{name:25s} {then[0]:5.0f} ms ({then[1]:5.0f} of CPU), first {first[0]:5.0f} "
            f"({first[1]:5.0f}); with searches {then[2]:5.0f} ({then[3]:5.0f}), first {first[2]:5.0f}"
        )

    pool = ThreadPoolExecutor(available_cores())
    sys.setswitchinterval(SWITCH)  # as the bench does
    os.environ["WORKBENCH_CACHE"] = "off"  # what is dragged first was never indexed
    for name, move in FOLLOWED.get(opened.study.environment.name, {}).items():
        begun = time.perf_counter()
        people.ready(start, move)  # as once it is chosen
        ready = 1e3 * (time.perf_counter() - begun)

        def dragged(number: int, move: Move = move) -> Edit:
            return shifted(opened, start, replace(move, by=(0.0, 0.0, 0.002 * (number + 1))))

        follow(name, dragged, 6)
        print(f"{'':25s} chosen {ready:5.0f} ms before")
    if opened.seat(crowd.row) is not None:

        def slid(number: int) -> Edit:
            forward = person.forward + 0.002 * (number + 1)
            return seated(opened, start, who, forward, person.up)

        follow("the seat", slid, 6)


def at_hand(study: wb.Study) -> wb.Study:
    """A study with as many people drawn from a population as are followed, if it draws any."""
    roles = []
    for role in study.roles:
        drawn = role.population
        many = replace(drawn, people=AT_HAND) if isinstance(drawn, PeopleDrawn) else drawn
        roles.append(replace(role, population=many))
    return replace(study, roles=tuple(roles))


def main() -> None:
    """Measure the study and the body that are named."""
    study = wb.load_study(sys.argv[1] if len(sys.argv) > 1 else "trainer_clearance")
    if len(sys.argv) > 2:
        body = wb.load_body(sys.argv[2])
        study = replace(study, roles=tuple(replace(role, body=body) for role in study.roles))
    opened = open_study(at_hand(study))
    spheres = [len(opened.start.body(row).sphere_names) for row in range(len(study.roles))]
    print(f"{study.name}: {len(spheres)} people of {spheres} spheres")
    measure(opened)
    if opened.crowd is not None:
        measure_people(opened)


if __name__ == "__main__":
    main()
