"""Chunks of a long work kept as files of arrays: whole or not there, believed only where they are
what they say.

A file begins with the hash of its key and of what follows; then stand, as JSON, the names, types
and shapes of the arrays and the texts that go with them, and the arrays one after the other, each
on a boundary of 64 bytes, so that they can be used where they lie on disk.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.contact.index_cache import write_whole
from workbench.errors import InputError

__all__ = ["Kept", "read_kept", "write_kept"]

_DIGEST = hashlib.blake2b().digest_size
_STEP = 64


class Kept(NamedTuple):
    """Arrays by name, and texts by name."""

    arrays: dict[str, NDArray[Any]]
    texts: dict[str, list[str]]


def read_kept(path: Path, key: bytes) -> Kept | None:
    """What a file holds, mapped into memory; None where there is none, or none that can be
    believed."""
    try:
        with path.open("rb") as file:
            digest = file.read(_DIGEST)
            told = hashlib.blake2b(key)
            while block := file.read(1 << 20):
                told.update(block)
        if digest != told.digest():
            return None
        whole = np.asarray(
            np.memmap(path, dtype=np.uint8, mode="r")
        )  # slices of a map cost as much as a small solve
        size = int.from_bytes(whole[_DIGEST : _DIGEST + 8].tobytes(), "little")
        head = json.loads(whole[_DIGEST + 8 : _DIGEST + 8 + size].tobytes())
        arrays = {}
        for name, (kind, shape, begin) in head["arrays"].items():
            end = begin + math.prod(shape) * np.dtype(kind).itemsize
            arrays[name] = whole[begin:end].view(kind).reshape(shape)
        return Kept(arrays, head["texts"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def write_kept(path: Path, key: bytes, kept: Kept) -> None:
    """Write a file in one step. InputError where the disk does not let us; what was there before
    stays."""
    arrays = {name: np.ascontiguousarray(values) for name, values in kept.arrays.items()}
    body = _packed(arrays, kept.texts)
    try:
        write_whole(path, hashlib.blake2b(key + body).digest() + body)
    except OSError as error:
        raise InputError(f"{path.parent}: cannot be written ({error.strerror})") from None


def _packed(arrays: Mapping[str, NDArray[Any]], texts: Mapping[str, list[str]]) -> bytes:
    """Length of the head, head, arrays; the head is made twice, since where the arrays begin stands
    in it."""
    begin = dict.fromkeys(arrays, 0)
    for _ in range(3):
        table = {name: [a.dtype.str, list(a.shape), begin[name]] for name, a in arrays.items()}
        head = json.dumps({"arrays": table, "texts": dict(texts)}, sort_keys=True).encode()
        at = _DIGEST + 8 + len(head) + 2 * _STEP
        for name, values in arrays.items():
            at = -(-at // _STEP) * _STEP
            begin[name] = at
            at = at + values.nbytes
    table = {name: [a.dtype.str, list(a.shape), begin[name]] for name, a in arrays.items()}
    head = json.dumps({"arrays": table, "texts": dict(texts)}, sort_keys=True).encode()
    packed = bytearray(len(head).to_bytes(8, "little") + head)
    for name, values in arrays.items():
        packed += bytes(begin[name] - _DIGEST - len(packed)) + values.tobytes()
    return bytes(packed)
