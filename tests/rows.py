"""Bodies of tests: a row with other values."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np

from workbench import Topology

SHARED = {field.name for field in fields(Topology)}


def changed(body, **values):
    """A body of one row with other values; those of the row stand without its axis."""
    shared = {name: values.pop(name) for name in SHARED & set(values)}
    rows = {
        name: value if isinstance(value, str) else np.asarray(value)[None]
        for name, value in values.items()
    }
    return replace(body, topology=replace(body.topology, **shared), **rows)


def rows_of(body, name):
    """A field of the first row, or one that all rows share."""
    return getattr(body, name) if name in SHARED else getattr(body, name)[0]
