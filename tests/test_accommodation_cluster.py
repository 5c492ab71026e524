"""The same chunks on a Dask cluster: the same numbers, a worker that dies loses nothing, no answer
is told soon."""

from __future__ import annotations

import os
import signal

import numpy as np
import pytest

import workbench as wb
from tests.toy_cockpit import write_toy
from workbench.files.study.reader import load_study
from workbench.study.accommodation import cluster
from workbench.study.accommodation import crew as crew_module
from workbench.study.accommodation.accommodation import accommodation_study
from workbench.study.accommodation.cluster import Cluster, cluster_at
from workbench.study.pipelines import population_study

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture
def toy(tmp_path, monkeypatch):
    monkeypatch.setattr(crew_module, "CHUNK", 2)
    return population_study(load_study(write_toy(tmp_path, people=8)))


def test_an_address_where_nobody_answers_is_told_within_ten_seconds(monkeypatch):
    assert cluster.PATIENCE < 10
    monkeypatch.setattr(cluster, "PATIENCE", 1)
    told = r"no Dask scheduler answers at 'tcp://127.0.0.1:9' within 1 s"
    with pytest.raises(wb.InputError, match=told), cluster_at("tcp://127.0.0.1:9"):
        pass


def test_an_address_that_is_none_is_told():
    with (
        pytest.raises(wb.InputError, match="such as tcp://host:8786"),
        cluster_at("nowhere at all"),
    ):
        pass


@pytest.mark.nightly
def test_a_worker_that_is_killed_loses_nothing(toy, tmp_path):
    alone = accommodation_study(toy)
    own = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with own, distributed.Client(own) as client:
        pids = list(client.run(os.getpid).values())
        killed = []

        def say(text):
            if text.startswith("person") and not text.startswith("person 0") and not killed:
                killed.append(pids[0])
                os.kill(pids[0], signal.SIGKILL)

        found = accommodation_study(toy, keep=tmp_path / "keep", say=say, workers=Cluster(client))
    assert killed
    for name in ("margin", "seat", "reason"):
        assert np.array_equal(getattr(found, name), getattr(alone, name), equal_nan=True), name
    assert found.reasons == alone.reasons and found.shares == alone.shares
