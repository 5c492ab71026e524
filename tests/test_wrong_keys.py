"""A key that a file may not have is told with its place, in every kind of file and at every depth."""

from __future__ import annotations

import random
import re
from functools import cache

import pytest
import yaml

from tests.conftest import ROOT
from workbench.cli import main
from workbench.errors import InputError, UsageError, WorkbenchError
from workbench.files.kinds import KINDS, json_schemas, kind_of
from workbench.files.yaml_text import read_yaml

FILES = {
    "study": "studies/trainer_crash.yaml",
    "body": "bodies/bubbleman.yaml",
    "environment": "environments/trainer/environment.yaml",
    "postures": "bodies/human_postures.yaml",
    "population": "bodies/populations/ansur2.yaml",
    "growth": "bodies/populations/cdc_growth.yaml",
    "encumbrance": "bodies/encumbrance/helmet.yaml",
    "rules": "studies/rules/fmvss_208.yaml",
    "simulation": "studies/simulations/trainer_lap.yaml",
}
WRONG = {"never": ["right"]}
"""A value that no key takes."""


@cache
def known_keys():
    """The keys that some kind of file has somewhere."""
    keys = set()
    for schema in json_schemas().values():
        for model in (schema, *schema.get("$defs", {}).values()):
            keys |= set(model.get("properties", {}))
    return sorted(keys)


def mappings(value, path=()):
    """The paths of all mappings of a file, one of a list for all its members."""
    if isinstance(value, dict):
        yield path
        for key, inner in value.items():
            yield from mappings(inner, (*path, key))
    elif isinstance(value, list) and value:
        yield from mappings(value[0], (*path, 0))


def with_key(value, path, key):
    """A copy of a file's value in which a mapping has one key more, or another value of one."""
    if not path:
        return {**value, key: WRONG}
    if isinstance(value, list):
        return [with_key(value[0], path[1:], key), *value[1:]]
    return {**value, path[0]: with_key(value[path[0]], path[1:], key)}


def checked(tmp_path, capsys, value):
    """The exit code of `check` for a file, and what it says."""
    file = tmp_path / "file.yaml"
    file.write_text(yaml.safe_dump(value, sort_keys=False, default_flow_style=None, width=1000))
    code = main(["check", str(file)])
    said = capsys.readouterr()
    return code, said.out + said.err


def test_there_is_a_file_of_every_kind():
    assert [kind_of(ROOT / FILES[kind]) for kind in KINDS] == list(KINDS)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("key", ["length", "never_a_key"])
def test_a_wrong_key_at_the_top_is_told_with_its_line(tmp_path, capsys, kind, key):
    value = read_yaml(ROOT / FILES[kind]).value
    code, said = checked(tmp_path, capsys, with_key(value, (), key))
    assert code == 3
    assert re.search(rf"file\.yaml:\d+:\d+: {key}: ", said)


@pytest.mark.parametrize("kind", KINDS)
def test_a_wrong_key_at_any_depth_is_told(tmp_path, capsys, kind):
    value = read_yaml(ROOT / FILES[kind]).value
    places = list(mappings(value))
    chance = random.Random(kind)
    for _ in range(6):
        path = chance.choice(places)
        key = chance.choice(known_keys())
        code, said = checked(tmp_path, capsys, with_key(value, path, key))
        assert code == 3, (path, key)
        assert re.search(r"file\.yaml:\d+:\d+: \S", said), (path, key, said)


def test_a_posture_file_with_a_unit_is_told_wherever_its_body_is_used(tmp_path, capsys):
    text = (ROOT / "bodies" / "human_postures.yaml").read_text()
    (tmp_path / "human_postures.yaml").write_text(
        text.replace("reference", "length: mm\nreference", 1)
    )
    (tmp_path / "body.yaml").write_text((ROOT / "bodies" / "bubbleman.yaml").read_text())
    study = tmp_path / "study.yaml"
    study.write_text(
        "study: sits\nlength: mm\nenvironment: trainer\npeople: {a: {body: body.yaml, seat: left}}\n"
        "cases: [{name: drives, people: {a: {posture: driving}}}]\n"
        "criteria: [{name: stops, check: stops}]\n"
    )
    for command in (["body", "show", str(tmp_path / "body.yaml")], ["check", str(study)]):
        assert main(command) == 3
        assert "human_postures.yaml:3:1: length: unknown key 'length'" in capsys.readouterr().err


@pytest.mark.parametrize("kind", [WorkbenchError, UsageError, InputError])
@pytest.mark.parametrize("nothing", ["", " \n"])
def test_no_error_is_empty(kind, nothing):
    with pytest.raises(ValueError, match="no text says what is wrong"):
        kind(nothing)
    with pytest.raises(ValueError, match="no text says what is wrong"):
        InputError([])
