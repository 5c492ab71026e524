"""Names come out whole: a cockpit whose things have other names gives the same results in the same
words, whatever stands in the names."""

from __future__ import annotations

import html
import json
import re
from dataclasses import replace
from functools import cache
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.accommodations import made, trainer_people
from tests.conftest import ROOT
from tests.toy_cockpit import STUDY, write_toy
from workbench.cli import main
from workbench.model.accommodation import Requirement
from workbench.model.criterion import Kind, Reason
from workbench.report.population.sentences import person_sentence

FLAPS = Requirement("reach flaps", "engine and cabin", "reach", "flaps", 2)
STRANGE = {
    "knob": "knob at post: a, b hides 5 %",
    "near": "near, limited by it in zone 2",
    "panel": "panel, at the own roof",
    "roof": "roof: outside, at seat",
    "dial": "dial at angle, size: turned",
}
"""Names that hold what stands between names in sentences; they stand in the order of the plain ones."""
MORE = """
  - {name: sight, check: sees, controls: [near], at_least: 100, eyes: both}
  - {name: behind, check: sees, points: [aft], at_least: 100}
  - {name: reading, check: reads, instruments: [dial], rules: sight_nureg_0700}
  - {name: nose, check: over_nose, down: 60, parts: [panel]}
  - {name: front, check: outline, rules: sight_ac_25_773_1, side: left, at_least: 99.9}
  - {name: all ahead, check: sees, parts: [panel], at_least: 100}
"""
ONE = STUDY.replace(", population: {people: PEOPLE, seed: 3}", "") + MORE.lstrip("\n")
CROWD = STUDY + MORE.lstrip("\n")


def renamed(text):
    """A file of the cockpit with the strange names."""
    for plain, strange in STRANGE.items():
        text = re.sub(rf"(?<![\w.'\"]){plain}(?![\w.'\"])", f"'{strange}'", text)
    return text


def told(folder, capsys, study, *, strange):
    """What the command line, the page and the files of results say, with the plain names again."""
    path = write_toy(folder, study=study, people=4)
    room = folder / "environments/toy/environment.yaml"
    text = room.read_text().replace("points:\n", "points:\n  aft: [-3000, 0, 1100]\n")
    room.write_text(text + "instruments:\n  dial: {part: panel, characters: 2}\n")
    if strange:
        room.write_text(renamed(room.read_text()))
        path.write_text(renamed(path.read_text()))
        mesh = room.parent / "toy.obj"
        mesh.write_text(
            re.sub(
                "^o (.*)", lambda m: f"o {STRANGE.get(m[1], m[1])}", mesh.read_text(), flags=re.M
            )
        )
    code = main(["run", str(path), "--out", str(folder / "out")])
    streams = [stream.replace(str(folder), "") for stream in capsys.readouterr()]
    texts = [f"exit {code}", *streams]
    for one in sorted(folder.glob("out/*.html")):
        words = re.sub(r"<(script|style)\b.*?</\1>|<[^>]+>", " ", one.read_text(), flags=re.DOTALL)
        texts.append(re.sub(r"\s+", " ", html.unescape(words)))
    for one in sorted(folder.glob("out/*.json")):
        found = json.loads(one.read_text())
        found.pop("provenance", None)
        texts.append(json.dumps(found, indent=1, ensure_ascii=False))
    return texts


@cache
def one_person():
    """A person who misses one requirement by 12 mm."""
    return made(trainer_people(1), [FLAPS], [[-0.012]], reason=np.array([[0]]))


@given(
    st.sampled_from(
        ["reach", "clearance", "over_nose", "forward_field", "outline", "mirror", "pedals"]
    ),
    st.sampled_from(sorted({*get_args(Kind)} - {"", "limb", "reading"})),  # these have no names
    st.text(", :%'()ahidestouwn", min_size=1).map(str.split).map(" ".join).filter(bool),
    st.sampled_from([0.0, 0.031]),
)
def test_what_limits_is_named_whole_in_a_sentence(check, kind, name, share):
    result = replace(one_person(), requirements=(replace(FLAPS, check=check),))
    words = [
        person_sentence(replace(result, reasons=(Reason(kind, one, share=share),)), 0)
        for one in ("XYZ", f"X{name}Z")
    ]
    assert words[0].replace("XYZ", f"X{name}Z") == words[1]
    assert f"X{name}Z" in words[1]


@pytest.mark.nightly
@pytest.mark.parametrize("study", [ONE, CROWD], ids=["one", "crowd"])
def test_names_that_hold_commas_and_the_words_of_sentences_come_out_whole(tmp_path, capsys, study):
    plain, strange = (
        told(tmp_path / str(which), capsys, study, strange=which) for which in (False, True)
    )
    assert len(plain) > 4
    for one, other in zip(plain, strange, strict=True):
        for name, written in STRANGE.items():
            other = other.replace(written, name)
        assert one == other


def test_one_function_writes_names_for_reading():
    """`errors`, below all rooms, compares names with what was typed and shows none so."""
    package = ROOT / "workbench"
    blank = re.compile(r"""replace(?:All)?\((['"])_\1, (['"]) \2\)""")
    files = [path for kind in ("*.py", "*.js") for path in package.rglob(kind)]
    found = {
        path.relative_to(package).as_posix() for path in files if blank.search(path.read_text())
    }
    assert found == {"model/units.py", "draw/web/pick.js", "errors.py"}
