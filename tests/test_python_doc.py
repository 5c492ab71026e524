"""The page about Python is true: its blocks run one after another, and say what they are said to."""

from __future__ import annotations

import re

import workbench as wb
from tests.conftest import ROOT

BLOCKS = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "python.md").read_text(), re.S)


def test_the_blocks_run_in_their_order(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in BLOCKS:
        exec(compile(block, "docs/python.md", "exec"), names)
    said = capsys.readouterr().out
    assert len(BLOCKS) == 7
    swept = re.findall(r"^([+-]\d+) mm: (passed|FAILED), (-?\d+) mm to spare$", said, re.M)
    assert [int(row[0]) for row in swept] == [-50, -25, 0, 25, 50]
    assert "\nResult(study: 2 of 2 criteria hold)\nVerdict(throttle: passed" in said
    assert (tmp_path / "flying.png").stat().st_size > 10_000
    assert re.search(
        r"^left pillar: 0\.0(59|60|61) sr to the left eye, 0\.0(19|20) to both$", said, re.M
    )
    assert "98 % of the ground beside the car is seen in the left mirror" in said
    stricter = names["stricter"]
    assert isinstance(stricter, wb.Study)
    assert [(one.name, one.at_least) for one in stricter.criteria] == [("head to canopy", 0.04)]


def test_a_sweep_of_five_positions_is_five_lines():
    (sweep,) = (block for block in BLOCKS if block.startswith("for "))
    assert len(sweep.splitlines()) == 5
