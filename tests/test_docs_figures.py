"""Figures in the documents are what a run of a shipped study says (`tools/docs_figures.py`)."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from tests.conftest import ROOT

FIGURE = re.compile(r"<!-- (studies/\S+): (\w+) -->\n(.*?)<!-- end -->", re.DOTALL)
DOCUMENTS = ("accommodation", "driving", "crash-simulation")


@pytest.mark.parametrize("name", DOCUMENTS)
def test_figures_of_documents_name_a_shipped_study_and_are_there(name):
    found = FIGURE.findall((ROOT / "docs" / f"{name}.md").read_text())
    assert found
    for study, kind, text in found:
        assert (ROOT / study).exists()
        assert kind in ("headline", "verdicts", "groups", "changes")
        assert re.search(r"\d", text), f"{name}.md: python tools/docs_figures.py writes {kind}"


@pytest.mark.nightly
@pytest.mark.parametrize("name", DOCUMENTS)
def test_figures_of_documents_are_those_of_a_run(name):
    tool = [sys.executable, ROOT / "tools/docs_figures.py", "--check", ROOT / f"docs/{name}.md"]
    done = subprocess.run(tool, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
