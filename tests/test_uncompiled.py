"""The kernels with the compiler off: an index out of bounds shows, and the answers are the same."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from tests.conftest import ROOT
from tests.pictures_plain import CALLS, as_text

TESTS = ["tests/test_collide.py", "tests/test_forward.py"]
SKIPPED = "bubbleman or library or standing or stays_at or incremental or re_rooting or joint or enclosing or posture"


def printed(*module: str) -> str:
    """What a fresh Python prints that runs a module with the compiler off."""
    command = [sys.executable, "-m", *module]
    env = os.environ | {"NUMBA_DISABLE_JIT": "1", "WORKBENCH_EXAMPLES": "3"}
    done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


@pytest.fixture(scope="module")
def plain():
    """What each call gives with the compiler off."""
    return json.loads(printed("tests.pictures_plain"))


@pytest.mark.parametrize("call", CALLS)
def test_kernels_of_pictures_give_the_same_with_the_compiler_off(plain, call):
    compiled = as_text(CALLS[call])
    assert compiled == plain[call] and len(compiled) > 500


def test_kernels_pass_with_the_compiler_off():
    printed("pytest", "-p", "no:cacheprovider", *TESTS, "-k", f"not ({SKIPPED})")
