"""Sight at the bench: what people see while something is dragged, and where they look."""

from __future__ import annotations

import json

import pytest

import workbench as wb
from tests.conftest import ROOT
from workbench.live.protocol import parsed, unpacked
from workbench.model.units import UNITS

pytest.importorskip("starlette", reason="the extra `live` is not installed")
pytest.importorskip("uvicorn", reason="the extra `live` is not installed")

from workbench.live.desk import Desk

SIGHT = """
  - {name: over the nose, check: over_nose, down: 14}
  - {name: panel seen, check: sees, instruments: [tachometer, altimeter], at_least: 80}
  - {name: throttle seen, check: sees, controls: [throttle], at_least: 50}
  - {name: outline, check: outline, rules: sight_ac_25_773_1, side: left, people: [pilot], at_least: 80}
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("sight") / "two_see.yaml"
    path.write_text((ROOT / "tests" / "data" / "two_men.yaml").read_text().rstrip() + SIGHT)
    return path


@pytest.fixture
def desk(study):
    found = Desk(str(study))
    found.state()
    return found


def asked(desk, text):
    """The replies of a desk to a question."""
    return desk.do(parsed(text))


def sights(desk):
    """The rows of what is seen now, by the names of their criteria."""
    heads = [unpacked(frame)[0] for frame in desk.judgement().sights()]
    assert all(head["generation"] == desk.generation for head in heads)
    return {head["row"]["name"]: head["row"] for head in heads}


RAISED = '{"do": "move", "parts": ["coaming"], "by": [0, 0, 0.08], "done": %s}'


def test_what_is_seen_while_the_coaming_is_dragged_is_what_a_run_of_the_saved_study_finds(
    desk, study
):
    before = study.read_text()
    assert sights(desk)["over the nose"]["passed"]
    asked(desk, RAISED % "false")
    rows = []
    for case in desk.opened.cases:
        asked(desk, json.dumps({"do": "case", "name": case}))
        rows.append(sights(desk))
    asked(desk, RAISED % "true")
    asked(desk, '{"do": "save"}')
    run = wb.run(wb.load_study(study))
    study.write_text(before)
    found = {one.criterion.name: one for one in run.verdicts if one.criterion.name in rows[0]}
    assert len(found) == 4 and found["over the nose"].worst.target == "coaming"
    for name, verdict in found.items():
        worst = min((row[name] for row in rows), key=lambda row: row["margin"])
        unit = UNITS[verdict.worst.unit]
        assert worst["now"] and worst["passed"] == verdict.passed
        assert worst["margin"] == pytest.approx(unit.scale * verdict.worst.margin, abs=1e-9)
    assert "coaming" in rows[0]["over the nose"]["words"] + rows[1]["over the nose"]["words"]
