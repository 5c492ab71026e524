"""docs/accommodation.md is true: its study loads, its code runs."""

from __future__ import annotations

import re

import pytest

from tests.conftest import ROOT
from workbench.cli import main

TEXT = (ROOT / "docs" / "accommodation.md").read_text()
BLOCKS = dict(re.findall(r"```(\w+)\n(.*?)```", TEXT, re.S))


def test_the_study_of_the_page_checks(tmp_path):
    path = tmp_path / "small_crew.yaml"
    path.write_text(BLOCKS["yaml"])
    assert main(["check", str(path)]) == 0


@pytest.mark.nightly
def test_the_code_of_the_page_runs(tmp_path, monkeypatch, capsys):
    (tmp_path / "small_crew.yaml").write_text(BLOCKS["yaml"])
    monkeypatch.chdir(tmp_path)
    exec(compile(BLOCKS["python"], "accommodation.md", "exec"), {})
    assert "GroupShare(group='everybody'" in capsys.readouterr().out
