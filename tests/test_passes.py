"""How far a run says that it is: every pass by its name, a count that moves, a time left that does not
rise."""

from __future__ import annotations

import re
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.cli.progress import Progress
from workbench.study.executors import completed, worked
from workbench.study.passes import ASKING, BODIES, CHANGE, LAST, Passes

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
    # bodies 1 s, asking 10 s, three changes 5 s each, the rest 3 s: 29 s in all
    lines = told([1, 10, 5, 5, 5, 3], steps=10)
    assert lines[0] == "bodies: 0 of 100 people"  # nothing is known yet
    assert "asking: 50 of 100 people, 23 s left" in lines
    assert "change: 0 of 100 people, 18 s left" in lines


def test_where_it_takes_far_longer_than_was_said_no_time_is_told():
    lines = told([1, 10, 5, 5, 5, 300], steps=10)
    assert seconds_left(lines[-10]) is not None and seconds_left(lines[-5]) is None


def half_a_job(seconds):
    worked(0.5)
    time.sleep(seconds)
    return seconds


def test_jobs_of_other_processes_are_counted_in_part_while_they_last(monkeypatch):
    monkeypatch.setattr("workbench.study.executors.BEAT", 0.05)
    monkeypatch.setattr("workbench.study.executors.cores", lambda: 2)
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
