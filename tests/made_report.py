"""A run of a study that reads little and writes a report of two words, for tests of who asks for it."""

from __future__ import annotations

import time
from pathlib import Path
from types import SimpleNamespace

from workbench.errors import InputError
from workbench.files.output_folder import write_folder

__all__ = ["reported"]


def reported(source, *, say):
    """What is told of the report of a study file; one that says "wrong" cannot be run, one that says
    "long" takes ten minutes."""
    text = Path(source).read_text()
    if "wrong" in text:
        raise InputError(f"{source}: it is wrong")
    say("asking everybody: 1 of 3 people, 2 s left")
    if "long" in text:
        time.sleep(600)
    folder = Path(source).with_name("out")
    write_folder(folder, {"report.html": "<p>Two of three", "tables/a.csv": "1\n"}, holds="result")
    return SimpleNamespace(folder=folder, headline="Two of three.", lines=("90 %",), warnings=())
