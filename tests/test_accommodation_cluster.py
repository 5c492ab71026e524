"""The same chunks on a Dask cluster: the same numbers, and a worker that dies loses nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import workbench as wb
from tests.crowds import crowd_of
from tests.toy_cockpit import write_toy
from workbench.study import executors
from workbench.study.accommodation import population_bodies
from workbench.study.accommodation.accommodation import accommodation
from workbench.study.accommodation.population_bodies import fit_population
from workbench.study.executors import completed, dask_executor, local_executor

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture
def toy(tmp_path, monkeypatch):
    monkeypatch.setattr(population_bodies, "CHUNK_SIZE", 2)
    monkeypatch.setattr(population_bodies, "MAX_CHUNKS_TOGETHER", 1)
    return crowd_of(write_toy(tmp_path, people=8))


def test_an_address_where_nobody_answers_is_reported_within_ten_seconds(monkeypatch):
    assert executors.SCHEDULER_TIMEOUT < 10
    monkeypatch.setattr(executors, "SCHEDULER_TIMEOUT", 1)
    reported = r"no Dask scheduler answers at 'tcp://127.0.0.1:9' within 1 s"
    with pytest.raises(wb.InputError, match=reported), dask_executor("tcp://127.0.0.1:9"):
        pass


def test_an_address_that_is_none_is_reported():
    with (
        pytest.raises(wb.InputError, match="such as tcp://host:8786"),
        dask_executor("nowhere at all"),
    ):
        pass


def test_bodies_are_the_same_bytes_here_in_processes_and_on_a_cluster(toy, monkeypatch):
    monkeypatch.setenv("WORKBENCH_CACHE", "off")
    monkeypatch.setattr(executors, "available_cores", lambda: 1)
    some = toy.people.rows(np.arange(4))
    found = [fit_population(toy.body, some)]
    for connect in (lambda: local_executor(2), lambda: dask_executor("local")):
        with connect() as executor:
            found.append(fit_population(toy.body, some, executor=executor))
    for other in found[1:]:
        for name, values in found[0].fields.items():
            assert values.tobytes() == other.fields[name].tobytes(), name


def test_a_cluster_without_a_worker_is_given_up(monkeypatch):
    assert executors.WORKERLESS_TIME <= 60
    monkeypatch.setattr(executors, "WORKERLESS_TIME", 1.0)
    own = distributed.LocalCluster(n_workers=0, dashboard_address=None)
    given_up = rf"the cluster at '{own.scheduler_address}' has had no worker for 1 s: start one"
    with (
        own,
        pytest.raises(wb.InputError, match=given_up),
        dask_executor(own.scheduler_address) as one,
    ):
        list(completed(abs, [1, 2], lambda key: (key,), executor=one))


@pytest.mark.nightly
def test_a_worker_that_is_killed_loses_nothing(toy, tmp_path):
    alone = accommodation(toy.study)
    own = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with own, distributed.Client(own) as client:
        pids = list(client.run(os.getpid).values())
        killed = []

        def say(text):
            if text.startswith("asking") and ": 0 of" not in text and not killed:
                killed.append(pids[0])
                os.kill(pids[0], signal.SIGKILL)

        with dask_executor(own.scheduler_address) as executor:
            found = accommodation(toy.study, keep=tmp_path / "keep", say=say, executor=executor)
    assert killed
    for name in ("margin", "seat", "reason"):
        assert np.array_equal(getattr(found, name), getattr(alone, name), equal_nan=True), name
    assert found.reasons == alone.reasons and found.shares == alone.shares


@pytest.mark.nightly
def test_a_scheduler_that_is_gone_is_one_message(toy, tmp_path, capfd):
    address = "tcp://127.0.0.1:8797"
    start = [sys.executable, "-m", "dask", "scheduler", "--port", "8797", "--no-dashboard"]
    with subprocess.Popen(start, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as own:
        gone = (
            rf"the Dask scheduler at '{address}' is gone, and with it the jobs that were not done"
        )
        time.sleep(8.0)
        capfd.readouterr()
        with pytest.raises(wb.InputError, match=gone), dask_executor(address) as executor:
            jobs = completed(abs, [1, 2], lambda key: (key,), executor=executor)
            own.kill()
            list(jobs)
    assert "Traceback" not in capfd.readouterr().err
