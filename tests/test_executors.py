"""Work shared among processes: the same answers for any number, and an end without remains."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

import workbench as wb
from tests.toy_cockpit import write_toy
from workbench import load_study
from workbench.study import executors
from workbench.study.accommodation import population_bodies
from workbench.study.accommodation.accommodation import accommodation
from workbench.study.executors import Shared, completed
from workbench.threads import available_cores

BOTH = multiprocessing.Barrier(2)
HERE = []
"""Numbers that this process has worked on."""


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    monkeypatch.setattr(executors, "available_cores", lambda: 2)


def alone(number):
    return (number,)


def squared(number):
    return number * number, os.getpid()


def squared_by_both(number):
    if not HERE:  # the first job of each process waits until the other has one too
        HERE.append(number)
        BOTH.wait(timeout=600)
    return squared(number)


def number_of_cores(number):
    return available_cores()


def refused(number):
    raise wb.InputError([f"job {number} is bad", "and here is why"])


def killed_at_one(number):
    if number == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def identity(shared, number):
    return id(shared.value)


@pytest.mark.skipif(sys.platform != "linux", reason="a barrier is inherited by forks alone")
def test_every_job_is_done_once_by_two_others_than_this_process():
    found = dict(completed(squared_by_both, range(12), alone))
    assert {number: value for number, (value, _) in found.items()} == {
        number: number * number for number in range(12)
    }
    doers = {pid for _, pid in found.values()}
    assert len(doers) == 2 and os.getpid() not in doers


def test_one_job_or_one_core_is_worked_on_here(monkeypatch):
    assert [found for _, found in completed(squared, [3], alone)] == [(9, os.getpid())]
    monkeypatch.setattr(executors, "available_cores", lambda: 1)
    assert {pid for _, (_, pid) in completed(squared, range(4), alone)} == {os.getpid()}


def test_a_process_works_with_one_thread():
    assert [found for _, found in completed(number_of_cores, range(2), alone)] == [1, 1]


def test_the_environment_says_how_many_cores_may_be_used(monkeypatch):
    monkeypatch.setenv("WORKBENCH_THREADS", "1")
    assert available_cores() == 1
    monkeypatch.setenv("WORKBENCH_THREADS", "many")
    with pytest.raises(
        wb.UsageError, match="WORKBENCH_THREADS is a number of cores, 1 or more, got 'many'"
    ):
        available_cores()


def test_jobs_are_drawn_shortly_before_their_turn():
    drawn = []

    def arguments(number):
        drawn.append(number)
        return (number,)

    with closing(completed(squared, range(100), arguments)) as ready:
        next(ready)
        assert len(drawn) == 4


@pytest.mark.skipif(sys.platform != "linux", reason="only forks have the values of their parent")
def test_a_shared_value_is_not_copied_for_forks():
    shared = Shared({"a": 1})
    found = [at for _, at in completed(identity, range(4), lambda number: (shared, number))]
    assert found == [id(shared.value)] * 4


def test_a_shared_value_is_unpickled_once_in_another_process():
    shared = Shared({"a": 1})
    sent = [pickle.dumps(shared) for _ in range(2)]
    assert pickle.loads(sent[0]) is shared
    del shared  # from here on this process is like any other
    first, second = (pickle.loads(one) for one in sent)
    assert first.value == {"a": 1} and first is second


def test_an_error_of_a_job_is_raised_as_it_would_be_here():
    with pytest.raises(wb.InputError, match=r"job \d is bad") as caught:
        list(completed(refused, range(3), alone))
    assert caught.value.problems[1] == "and here is why"
    assert not multiprocessing.active_children()


def test_a_process_that_is_killed_is_reported_and_none_is_left():
    with pytest.raises(wb.InputError, match="was killed: the machine may be out of memory"):
        list(completed(killed_at_one, range(4), alone))
    assert not multiprocessing.active_children()


def test_who_stops_listening_ends_the_processes():
    ready = completed(squared, range(50), alone)
    next(ready)
    ready.close()
    assert not multiprocessing.active_children()


def long_after_the_first(number):
    time.sleep(600 * (number > 0))


def test_an_interruption_ends_running_jobs_at_once():
    ready = completed(long_after_the_first, range(4), alone)
    next(ready)
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt), closing(ready):
        raise KeyboardInterrupt
    assert time.monotonic() - begun < 60
    assert not multiprocessing.active_children()


def large(number):
    time.sleep(0.01 * number)
    return bytes(10_000_000)


def test_a_result_on_its_way_never_stops_an_interruption():
    for _ in range(5):
        ready = completed(large, range(20), alone)
        next(ready)
        ready.close()
        assert not multiprocessing.active_children()


ORPHANS = """
import os, pathlib, sys, time
from workbench.study import executors
executors.cores = lambda: 2
def work(number):
    pathlib.Path(sys.argv[1], str(os.getpid())).touch()
    time.sleep(0.2)
    return number
if __name__ == "__main__":
    list(executors.completed(work, range(1000), lambda number: (number,)))
"""


def test_processes_end_when_their_parent_is_killed(tmp_path):
    script = tmp_path / "orphans.py"
    script.write_text(ORPHANS)
    folder = tmp_path / "pids"
    folder.mkdir()
    parent = subprocess.Popen([sys.executable, str(script), str(folder)])
    pids = []
    while len(pids) < 2 and parent.poll() is None:
        time.sleep(0.02)
        pids = [int(path.name) for path in folder.iterdir()]
    assert len(pids) == 2
    parent.kill()
    parent.wait()
    latest = time.monotonic() + 120
    while any(running(pid) for pid in pids):
        assert time.monotonic() < latest, "children are still there"
        time.sleep(0.05)


def running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().split(")")[1].split()[0] != "Z"
    except OSError:
        return False


def test_an_interrupted_run_reports_what_is_kept_and_leaves_no_process(tmp_path, monkeypatch):
    monkeypatch.setattr(population_bodies, "CHUNK_SIZE", 2)
    monkeypatch.setattr(population_bodies, "MAX_CHUNKS_TOGETHER", 1)

    def say(text):
        if text.startswith("asking everybody") and ": 0 of" not in text:
            raise KeyboardInterrupt

    plan = load_study(write_toy(tmp_path, people=8))
    with pytest.raises(
        KeyboardInterrupt, match=r"stopped after [2-8] of 8 people: what was done is kept"
    ) as stopped:
        accommodation(plan, keep=tmp_path / "keep", say=say)
    done = int(str(stopped.value).split()[2])
    assert len(list((tmp_path / "keep").glob("*.chunk"))) == done // 2
    assert not multiprocessing.active_children()
    reported = []
    accommodation(plan, keep=tmp_path / "keep", say=reported.append)
    assert f"asking everybody: 0 of {8 - done} people" in reported


RUN = """
import sys
from workbench.study import executors
from workbench.study.accommodation import population_bodies
executors.cores = lambda: 2
population_bodies.CHUNK_SIZE = 4
population_bodies.MAX_CHUNKS_TOGETHER = 1
from workbench.cli import main
if __name__ == "__main__":
    raise SystemExit(main(["run", sys.argv[1], "--out", sys.argv[2]]))
"""


def test_ctrl_c_ends_a_run_and_its_processes_without_a_traceback(tmp_path):
    script = tmp_path / "run.py"
    script.write_text(RUN)
    study = write_toy(tmp_path, people=400)
    command = [sys.executable, str(script), str(study), str(tmp_path / "out")]
    run = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    while not list(tmp_path.glob(".out.chunks/*.chunk")) and run.poll() is None:
        time.sleep(0.05)
    os.killpg(run.pid, signal.SIGINT)
    _, reported = run.communicate(timeout=60)
    assert run.returncode == 130
    assert "stopped after" in reported and "Traceback" not in reported, reported
    with pytest.raises(ProcessLookupError):
        os.killpg(run.pid, 0)
