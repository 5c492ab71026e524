"""How far a run says that it is: every pass by its name, a count that moves, a time left that does not
rise."""

from __future__ import annotations

import re
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.cli.progress import Progress
from workbench.study.executors import completed, worked
from workbench.study.passes import ASKING, BODIES, CHANGE, LAST, USUAL_CHANGES, Passes

AHEAD = [BODIES, ASKING, CHANGE, CHANGE, CHANGE, LAST]


def told(durations, steps):
    """The lines of a run whose passes take so many seconds, each told of in so many steps."""
    now = [0.0]
    lines = []
    passes = Passes(lines.append, AHEAD, clock=lambda: now[0])
    for kind, seconds in zip(AHEAD, durations, strict=False):
        tell = passes.begin(kind, kind)
        for step in range(steps + 1):
            tell(100 * step / steps, 100)
            now[0] += seconds / steps if step < steps else 0.0
    return lines


def seconds_left(line):
    found = re.search(r", (\d+) (s|min) left$", line)
    return int(found[1]) * (60 if found[2] == "min" else 1) if found else None


@given(st.lists(st.floats(0.01, 900.0), min_size=1, max_size=6), st.integers(1, 30))
def test_the_time_left_never_rises_and_every_pass_is_named(durations, steps):
    lines = told(durations, steps)
    left = [s for line in lines if (s := seconds_left(line)) is not None]
    assert left == sorted(left, reverse=True)
    assert [line.split(":")[0] for line in lines[:: steps + 1]] == AHEAD[: len(durations)]


def test_the_time_left_is_that_of_all_passes_and_right_where_they_take_what_is_usual():
    # bodies 1 s, asking 10 s, three changes 2 s each, the rest 2 s: 13 s and 7 s, a quarter more is told
    lines = told([1, 10, 2, 2, 2, 2], steps=10)
    assert lines[0] == "bodies: 0 of 100 people"  # nothing is known yet
    assert "asking: 50 of 100 people, 16 s left" in lines
    assert "change: 50 of 100 people, 9 s left" in lines


def run_of_people(seed):
    """A run of a hundred people: the time [s] that is left in truth and the one told, when a quarter of
    it is over. People cost more or less (as far as thirtyfold), processes begin late, some of none to
    five changes ask few people again."""
    random = np.random.default_rng(seed)
    now = [0.0]
    lines = []
    ahead = [BODIES, ASKING, *[CHANGE] * USUAL_CHANGES, LAST]
    passes = Passes(lambda line: lines.append((now[0], line)), ahead, clock=lambda: now[0])
    person = 10.0 ** random.uniform(-1.3, 0.0) * random.lognormal(0.0, 1.0, 100)
    work = [(BODIES, 0.05 * person, 0.0), (ASKING, person, random.uniform(0, 0.5) * person.sum())]
    for _ in range(random.integers(0, 6)):
        again = random.random(100) < random.uniform(0.3, 1.0)
        work.append((CHANGE, again * person * random.uniform(0.05, 0.5), 0.0))
    for kind, costs, late in work:
        tell = passes.begin(kind, kind)
        tell(0, 100)
        now[0] += late
        for done, cost in enumerate(costs, 1):
            now[0] += cost
            tell(done, 100)
    end = now[0] + random.uniform(0.05, 0.4) * person.sum()
    return next(
        (end - at, left)
        for at, line in lines
        if at > end / 4 and (left := seconds_left(line)) is not None
    )


def test_the_time_told_when_a_quarter_is_over_is_mostly_right_within_a_factor_of_two():
    ratio = np.array([told / true for true, told in map(run_of_people, range(200))])
    assert np.mean((ratio > 0.5) & (ratio < 2.0)) > 0.8
    assert 0.7 < np.median(ratio) < 1.3


def test_where_it_takes_far_longer_than_was_said_no_time_is_told():
    lines = told([1, 10, 5, 5, 5, 300], steps=10)
    assert seconds_left(lines[-12]) is not None and seconds_left(lines[-5]) is None


def half_a_job(seconds):
    worked(0.5)
    time.sleep(seconds)
    return seconds


def test_jobs_of_other_processes_are_counted_in_part_while_they_last(monkeypatch):
    monkeypatch.setattr("workbench.study.executors.BEAT", 0.05)
    monkeypatch.setattr("workbench.study.executors.available_cores", lambda: 2)
    counts = []
    jobs = completed(half_a_job, [0.4, 0.4], lambda s: (s,), waiting=counts.append)
    assert [result for _, result in jobs] == [0.4, 0.4]
    assert counts == sorted(counts) and 1.0 in counts and counts[-1] == 2.0
    assert counts[0] <= 1.0


def test_a_log_has_few_lines_and_one_early(monkeypatch, capsys):
    monkeypatch.setattr("workbench.cli.progress.FIRST_WORD", 0.05)
    monkeypatch.setattr("workbench.cli.progress.QUIET_TIME", 0.2)
    with (
        pytest.raises(KeyboardInterrupt, match=r"^stopped \(it was at: asking: 299 of 300\)$"),
        Progress() as say,
    ):
        for done in range(300):
            say(f"asking: {done} of 300")
            time.sleep(0.003)
        raise KeyboardInterrupt
    lines = capsys.readouterr().err.splitlines()
    assert 2 <= len(lines) <= 5 and all(line.startswith("asking: ") for line in lines)
