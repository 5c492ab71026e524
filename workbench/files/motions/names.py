"""Read the file of `--names`: what the bones, markers or coordinates of a motion file are."""

from __future__ import annotations

from pathlib import Path

from workbench.errors import InputError
from workbench.files.schema import fail
from workbench.files.yaml_text import read_yaml

__all__ = ["load_names"]


def load_names(path: str | Path) -> dict[str, str]:
    """Read a YAML file with the same lines as `map` of a motion in a study.

    Returns
    -------
    dict
        Bones by segment, or usual names of markers or coordinates by those of the motion file, ""
        for one that is left out.

    Raises
    ------
    InputError
        With line and column, if it is no mapping of texts.
    """
    document = read_yaml(path)
    if not isinstance(document.value, dict):
        raise InputError(fail(document, (), "lines such as 'LUA: lhumerus' are needed"))
    names = {str(key): value for key, value in document.value.items()}
    wrong = [key for key, value in names.items() if not isinstance(value, str)]
    if wrong:
        raise InputError([fail(document, (key,), "a name is needed, in quotes") for key in wrong])
    return names
