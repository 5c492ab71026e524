"""The device's answers in the CUDA simulator, and what is said where there is none."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.util import find_spec

import pytest

import workbench as wb
from tests.conftest import ONE_ARM, ROOT
from workbench import MissingPartError
from workbench.contact.gpu import _pieces

installed = find_spec("numba_cuda") is not None


@pytest.mark.skipif(not installed, reason="numba-cuda is not installed")
def test_the_device_gives_the_processors_answers_in_the_simulator(tmp_path):
    body = tmp_path / "one_arm.yaml"
    body.write_text(ONE_ARM)
    done = subprocess.run(
        [sys.executable, "-m", "tests.cuda_simulated", str(body)],
        cwd=ROOT,
        env=os.environ | {"NUMBA_ENABLE_CUDASIM": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    told = json.loads(done.stdout.splitlines()[-1])
    assert told["clearance"] < 1e-5 and told["by_segment"] < 1e-5
    assert told["witnesses"] and told["collides"] and told["posed"]
    assert 0 < told["hits"] < 70


@pytest.mark.skipif(installed, reason="numba-cuda is installed")
def test_without_the_package_its_name_is_told(one_arm, box_cab):
    placed = wb.place(one_arm, wb.pose(one_arm, {}))
    with pytest.raises(
        MissingPartError, match=r"numba-cuda.*pip install 'bubbleman-workbench\[gpu\]'"
    ) as told:
        wb.clearance(placed, box_cab, device="cuda")
    assert told.value.exit_code == 4


def test_a_device_that_is_no_device_is_told(one_arm, box_cab):
    placed = wb.place(one_arm, wb.pose(one_arm, {}))
    for ask in (wb.clearance, wb.collides):
        with pytest.raises(wb.UsageError, match=r"device='gpu'.*valid: cpu, cuda"):
            ask(placed, box_cab, device="gpu")


def test_batches_larger_than_the_memory_go_in_pieces():
    assert _pieces(10, 1 << 29) == [(0, 4), (4, 8), (8, 10)]
    assert _pieces(3, 1 << 40) == [(0, 1), (1, 2), (2, 3)]
    assert _pieces(0, 8) == []
