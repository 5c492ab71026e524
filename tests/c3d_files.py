"""Small C3D files of every kind of processor and number, written by hand."""

from __future__ import annotations

import struct

import numpy as np

__all__ = ["c3d_file"]


def _dec(values: np.ndarray) -> bytes:
    """VAX F floating: four times the number of IEEE 754, its two words exchanged."""
    words = (np.asarray(values, dtype=np.float64) * 4).astype("<f4").view("<u2").reshape(-1, 2)
    return words[:, ::-1].tobytes()


def _reals(values: object, processor: int) -> bytes:
    given = np.atleast_1d(np.asarray(values, dtype=np.float64))
    return (
        _dec(given)
        if processor == 85
        else given.astype(">f4" if processor == 86 else "<f4").tobytes()
    )


def _parameter(
    group: int, name: str, kind: int, dimensions: tuple[int, ...], data: bytes, order: str
) -> bytes:
    body = struct.pack("bB", kind, len(dimensions)) + bytes(dimensions) + data + b"\0"
    return (
        struct.pack("bb", len(name), group)
        + name.encode()
        + struct.pack(order + "H", len(body) + 2)
        + body
    )


def c3d_file(
    points: np.ndarray | None = None,
    *,
    processor: int = 84,
    real: bool = True,
    labels: tuple[str, ...] = ("LHEE", "RASI"),
) -> bytes:
    """A C3D file of points (F, M, 3) [mm] at 100 Hz; NaN where a point is not seen. Whole numbers
    count 0.1 mm."""
    if points is None:
        points = np.array(
            [[[0, 1, 2], [3, 900, 5]], [[0, 1, 2], [np.nan, np.nan, np.nan]]], dtype=np.float64
        )
    order = ">" if processor == 86 else "<"
    frames, markers = points.shape[:2]
    width = max(map(len, labels))
    text = "".join(label.ljust(width) for label in labels).encode()
    groups = struct.pack("bb", 5, -1) + b"POINT" + struct.pack(order + "H", 3) + b"\0"
    groups += _parameter(1, "UNITS", -1, (2,), b"mm", order)
    groups += _parameter(1, "RATE", 4, (), _reals(100, processor), order)
    groups += _parameter(1, "LABELS", -1, (width, len(labels)), text, order)
    groups += bytes(2)
    section = (bytes([1, 80, 1, processor]) + groups).ljust(512, b"\0")
    header = bytes([2, 80]) + struct.pack(order + "5H", markers, 0, 1, frames, 0)
    header += (
        _reals(-1 if real else 0.1, processor)
        + struct.pack(order + "2H", 3, 0)
        + _reals(100, processor)
    )
    rows = np.concatenate([points, np.zeros((frames, markers, 1))], axis=2)
    rows[np.isnan(points).any(axis=2)] = (0, 0, 0, -1)
    data = _reals(rows.ravel(), processor) if real else _whole(rows, order)
    return header.ljust(512, b"\0") + section + data


def _whole(rows: np.ndarray, order: str) -> bytes:
    counts = rows.copy()
    counts[..., :3] *= 10
    return np.round(counts).astype(order + "i2").tobytes()
