"""Work shared among processes of this machine: the same answers for any number, and an end without
remains."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import workbench as wb
from tests.toy_cockpit import write_toy
from workbench.files.study.reader import load_study
from workbench.study.accommodation import crew as crew_module
from workbench.study.accommodation import forks
from workbench.study.accommodation.accommodation import accommodation_study
from workbench.study.accommodation.forks import shared
from workbench.study.pipelines import population_study
from workbench.threads import cores

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="work is shared among forks on Linux alone"
)


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    monkeypatch.setattr(forks, "cores", lambda: 2)


def squared(number):
    return number * number, os.getpid()


def test_every_chunk_is_done_once_by_two_others_than_this_process():
    both = multiprocessing.get_context("fork").Barrier(2)
    here = []

    def together(number):
        if not here:  # the first chunk of each process waits until the other has one too
            here.append(number)
            both.wait(timeout=600)
        return squared(number)

    found = list(shared(together, range(12)))
    assert sorted(number for number, _ in found) == list(range(12))
    assert all(value == number * number for number, (value, _) in found)
    doers = {pid for _, (_, pid) in found}
    assert len(doers) == 2 and os.getpid() not in doers


def test_one_chunk_or_one_process_is_worked_on_here():
    assert [value for _, value in shared(squared, [3])] == [(9, os.getpid())]
    assert {pid for _, (_, pid) in shared(squared, range(4), processes=1)} == {os.getpid()}


def test_a_process_works_with_one_thread():
    assert [found for _, found in shared(lambda _: cores(), range(2))] == [1, 1]


def test_the_environment_says_how_many_cores_may_be_used(monkeypatch):
    monkeypatch.setenv("WORKBENCH_THREADS", "1")
    assert cores() == 1
    monkeypatch.setenv("WORKBENCH_THREADS", "many")
    with pytest.raises(
        wb.UsageError, match="WORKBENCH_THREADS is a number of cores, 1 or more, got 'many'"
    ):
        cores()


def test_what_is_wrong_with_a_chunk_is_told_as_it_would_be_here():
    def work(number):
        raise wb.InputError(f"chunk {number} is bad")

    with pytest.raises(wb.InputError, match=r"chunk \d is bad"):
        list(shared(work, range(3)))
    assert not multiprocessing.active_children()


def test_a_process_that_is_killed_is_told_and_none_is_left():
    def work(number):
        if number == 1:
            os.kill(os.getpid(), signal.SIGKILL)
        return number

    with pytest.raises(
        wb.InputError, match=r"ended before its work \(killed by signal 9\): is there memory left"
    ):
        list(shared(work, range(4)))
    assert not multiprocessing.active_children()


def test_who_stops_listening_ends_the_processes():
    ready = shared(squared, range(50))
    next(ready)
    ready.close()
    assert not multiprocessing.active_children()


def test_processes_end_when_their_parent_is_killed(tmp_path):
    code = f"""
import os, time, pathlib
from workbench.study.accommodation import forks
forks.cores = lambda: 2
def work(number):
    pathlib.Path({str(tmp_path)!r}, str(os.getpid())).touch()
    time.sleep(0.2)
    return number
print("begun", flush=True)
list(forks.shared(work, range(1000)))
"""
    parent = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
    pids = []
    while len(pids) < 2 and parent.poll() is None:
        time.sleep(0.02)
        pids = [int(path.name) for path in tmp_path.iterdir()]
    assert len(pids) == 2
    parent.kill()
    parent.wait()
    parent.stdout.close()
    latest = time.monotonic() + 120
    while any(running(pid) for pid in pids):
        assert time.monotonic() < latest, "children are still there"
        time.sleep(0.05)


def running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().split(")")[1].split()[0] != "Z"
    except OSError:
        return False


def test_an_interrupted_run_says_what_is_kept_and_leaves_no_process(tmp_path, monkeypatch):
    monkeypatch.setattr(crew_module, "CHUNK", 2)

    def say(text):
        if text.startswith("person 2"):
            raise KeyboardInterrupt

    plan = population_study(load_study(write_toy(tmp_path, people=8)))
    with pytest.raises(
        KeyboardInterrupt, match="stopped after 2 of 8 people: what was done is kept"
    ):
        accommodation_study(plan, keep=tmp_path / "keep", say=say)
    assert len(list((tmp_path / "keep").glob("*.chunk"))) == 1
    assert not multiprocessing.active_children()
    told = []
    accommodation_study(plan, keep=tmp_path / "keep", say=told.append)
    assert "person 0 of 6" in told
