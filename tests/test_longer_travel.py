"""Who fits a seat still fits when its travel is longer: nobody is lost between the positions that
are tried."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.toy_cockpit import write_toy
from workbench import load_study

SLOPE = 0.06
SWAP = {
    "  - {name: knobs, check: reach, controls: [knob, near], hand: right}\n": "",
    "below: 60, above: 60": "below: 20, above: 20",
    "at_least: 150": "at_least: 435",
}


def who_fits(folder, forward, up) -> np.ndarray:
    """(B,) who fits under a roof that rises to the front, on a seat that travels so far [mm]."""
    path = write_toy(folder, people=30, swap=SWAP)
    place = folder / "environments" / "toy"
    text = (place / "environment.yaml").read_text()
    travel = f"travel: {{forward: {list(forward)}, up: {list(up)}}}"
    (place / "environment.yaml").write_text(
        text.replace("travel: {forward: [0, 0], up: [0, 0]}", travel)
    )
    before, roof = (place / "toy.obj").read_text().split("o roof\n")
    lines = []
    for line in roof.splitlines():
        kind, *numbers = line.split()
        if kind == "v":
            x, y, z = map(float, numbers)
            line = f"v {x:g} {y:g} {z + SLOPE * x:g}"
        lines.append(line)
    (place / "toy.obj").write_text(before + "o roof\n" + "\n".join(lines) + "\n")
    return wb.run(load_study(path)).population.served


@pytest.mark.parametrize("up", [(-10, 64), (-64, 10)])
def test_who_fits_within_a_travel_fits_within_a_longer_one(tmp_path, up):
    short = who_fits(tmp_path, (-110, 130), up)
    long = who_fits(tmp_path, (-120, 130), (-70, 70))
    assert short.any() and not long.all()
    assert not (short & ~long).any()
