"""Which kind of file a file is, and checking it whole."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from workbench.errors import InputError
from workbench.files.body.bodies import load_body
from workbench.files.body.encumbrances import EncumbranceFile, load_encumbrance
from workbench.files.body.schema import BodyFile
from workbench.files.catalogue import is_file, is_folder
from workbench.files.crash.simulation_schema import SimulationFile
from workbench.files.crash.simulations import load_simulation
from workbench.files.environment_doubts import unknown_segments
from workbench.files.environment_schema import EnvironmentFile
from workbench.files.environments import load_environment
from workbench.files.populations import (
    GrowthFile,
    PopulationFile,
    load_growth,
    load_population_model,
)
from workbench.files.postures import PosturesFile, load_postures, posture_path
from workbench.files.results.comparison import ComparisonFile
from workbench.files.results.result import ResultFile
from workbench.files.schema import validate
from workbench.files.study.reader import load_study
from workbench.files.study.schema import RulesFile, StudyFile
from workbench.files.yaml_text import read_yaml
from workbench.model.study import Study

__all__ = [
    "KINDS",
    "Checked",
    "check_file",
    "is_environment",
    "is_mesh",
    "is_result",
    "json_schemas",
    "kind_of",
    "named_kind",
]

KINDS = (
    "study",
    "body",
    "environment",
    "postures",
    "population",
    "growth",
    "encumbrance",
    "rules",
    "simulation",
)
_MODELS: dict[str, type[BaseModel]] = {
    "body": BodyFile,
    "postures": PosturesFile,
    "environment": EnvironmentFile,
    "study": StudyFile,
    "population": PopulationFile,
    "growth": GrowthFile,
    "rules": RulesFile,
    "simulation": SimulationFile,
    "encumbrance": EncumbranceFile,
    "result": ResultFile,
    "comparison": ComparisonFile,
}


def kind_of(path: Path) -> str:
    """study, body, environment, postures, population, growth, encumbrance, rules or simulation, by
    the keys of the file; "mesh" where it is not YAML.

    InputError where a YAML file has no key that names its kind.
    """
    if path.is_dir():
        return "environment"
    if path.suffix.lower() not in (".yaml", ".yml"):
        return "mesh"
    kind = named_kind(path)
    if kind is None:
        raise InputError(
            f"{path}:1:1: one of the keys {', '.join(KINDS)} must say what this file is"
        )
    return kind


def named_kind(path: Path) -> str | None:
    """The kind of a YAML file whose keys fit best, so that one misspelt key does not make it
    another kind; None where none of the keys that name a kind is there."""
    value = read_yaml(path).value
    keys = set(value) if isinstance(value, dict) else set()
    if not keys & set(KINDS):
        return None
    if {"study", "kind"} <= keys:  # a study of before there was one format, whose keys fit none
        return "study"
    fields = {kind: set(_MODELS[kind].model_fields) for kind in KINDS}
    return max(KINDS, key=lambda kind: (len(keys & fields[kind]), kind in keys))


def is_mesh(source: str) -> bool:
    """True where a source is a mesh file by its ending, False for environment folders, YAML files
    and bare names."""
    path = Path(source)
    return not is_folder(path) and path.suffix.lower() not in ("", ".yaml", ".yml", ".json")


def is_result(path: Path) -> bool:
    """True where a path is a result.json, or a folder with one."""
    return path.suffix.lower() == ".json" or is_file(path / "result.json")


def is_environment(source: str) -> bool:
    """True where a source is a mesh, an environment's file, or a folder with one."""
    path = Path(source)
    if is_folder(path):
        return is_file(path / "environment.yaml")
    if is_mesh(source):
        return True
    return is_file(path) and named_kind(path) == "environment"


@dataclass(frozen=True)
class Checked:
    """What a file without faults is told to have: what is probably a mistake, and what it leaves
    open and the loader took to be so; and the study where it is one."""

    warnings: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    study: Study | None = None


def check_file(path: Path) -> Checked:
    """Load a file with all it names; returns what is to be told, raises InputError for its
    faults."""
    if not path.exists():
        raise InputError(f"{path}: no such file")
    kind = kind_of(path)
    if kind == "study":
        study = load_study(path)
        return Checked(study.warnings, study.environment.assumed, study)
    if kind == "body":
        body = load_body(path)
        postures = posture_path(path)
        if postures is not None:
            load_postures(postures, body)
        return Checked()
    if kind == "environment":
        environment = load_environment(path)
        unknown = unknown_segments(environment, _known_segments(path))
        return Checked((*environment.warnings, *unknown), environment.assumed)
    if kind == "postures":
        validate(read_yaml(path), PosturesFile)
        return Checked()
    if kind == "population":
        load_population_model(path)
        return Checked()
    if kind == "rules":
        validate(read_yaml(path), RulesFile)
        return Checked()
    if kind == "growth":
        load_growth(path)
        return Checked()
    if kind == "simulation":
        place = load_simulation(path).environment
        return Checked(place.warnings, place.assumed)
    if kind == "encumbrance":
        load_encumbrance(path)
        return Checked()
    raise InputError(
        f"{path}: a YAML file is needed; meshes are looked at with 'workbench inspect'"
    )


def _known_segments(environment: Path) -> list[str]:
    """The segments of people, and of the bodies in the catalogue that an environment lies in."""
    home = environment if environment.is_dir() else environment.parent
    found = list(load_body("adult_male").segments)
    for file in sorted((home.resolve().parents[1] / "bodies").glob("*.yaml")):
        if named_kind(file) == "body":
            found += load_body(file).segments
    return found


def json_schemas() -> dict[str, dict[str, Any]]:
    """The JSON Schemas of all files, by kind; for editors, and of result.json for its readers."""
    return {name: model.model_json_schema() for name, model in _MODELS.items()}
