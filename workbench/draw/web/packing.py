"""Pack scenes for the browser: numbered arrays and a JSON header, deflated, the same bytes twice.

A page holds several views, and many arrays are in several of them: an environment in every case, a
body in every posture. A `Packing` keeps each array once, by its bytes. The block is

1. four bytes, little-endian: the length of the header;
2. the header, JSON: `arrays` (how each is written) and `views` (which name arrays by index);
3. the arrays, one after the other.

Lengths are whole numbers of tenths of a millimetre from an origin: an error of 0.05 mm at most, a
tenth of what spheres are known to. What is small (radii) is written in hundredths. Arrays are
written as differences from the value `stride` places before (of a motion: from the frame before),
low bytes first and high bytes behind, which deflates to about a third.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.draw.web.place_mesh import environment_mesh
from workbench.draw.web.views import WebBody, WebGaps, WebMark, WebPlace, WebView
from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Environment

__all__ = ["FINE", "TENTH", "Packing"]

TENTH = 1e-4
"""Step [m] of lengths."""
FINE = 1e-5
"""Step [m] of lengths that all lie within 0.3 m of each other."""
_DEFLATED = 6
"""How hard is deflated. A place of 10^6 triangles (27 MB) takes 0.8 s of CPU time and gives 2.16 MB;
at level 9 it takes 14 s and gives 1.98 MB."""
_FAR = 0.5
"""Gaps [m] beyond are shown alike."""


@dataclass(frozen=True)
class _Array:
    """How an array is written: the entry of the header, and the bytes."""

    entry: dict[str, Any]
    data: bytes


@dataclass(eq=False)
class Packing:
    """The arrays and views of a page, as they are added."""

    arrays: list[_Array] = field(default_factory=list)
    views: list[dict[str, Any]] = field(default_factory=list)
    _known: dict[tuple[str, bytes], int] = field(default_factory=dict)
    _places: dict[int, tuple[Environment, dict[str, Any]]] = field(default_factory=dict)

    def add(self, view: WebView) -> int:
        """Add a view and return its index.

        Raises
        ------
        InputError
            If a coordinate is not finite.
        """
        if isinstance(view.environment, WebPlace):
            place: dict[str, Any] | None = self._mesh(view.environment)
        else:
            place = None if view.environment is None else self._place(view.environment)
        packed: dict[str, Any] = {
            "title": view.title,
            "from": view.look_from,
            "place": place,
            "bodies": [self._body(body) for body in view.bodies],
            "marks": [_mark(mark) for mark in view.marks],
            "times": None if view.times is None else _milliseconds(view.times),
            "gaps": None if view.gaps is None else self._gaps(view.gaps),
        }
        if view.begin is not None and view.times is not None:
            packed["begin"] = int(np.argmin(np.abs(np.array(view.times) - view.begin)))
        if view.states is not None:
            packed["states"] = list(view.states)
        self.views.append(packed)
        return len(self.views) - 1

    def block(self) -> bytes:
        """Return the deflated bytes of all views."""
        entries = [array.entry for array in self.arrays]
        text = {"arrays": entries, "views": self.views}
        header = json.dumps(text, ensure_ascii=False, separators=(",", ":")).encode()
        data = b"".join(array.data for array in self.arrays)
        maker = zlib.compressobj(_DEFLATED, zlib.DEFLATED, -15)
        whole = len(header).to_bytes(4, "little") + header + data
        return maker.compress(whole) + maker.flush()

    def text(self) -> str:
        """Return the block as base64 text, for a page."""
        return base64.b64encode(self.block()).decode("ascii")

    def _place(self, environment: Environment) -> dict[str, Any]:
        """Pack what is seen of an environment, once."""
        known = self._places.get(id(environment))
        if known is not None:
            return known[1]
        packed = self._mesh(environment_mesh(environment))
        self._places[id(environment)] = environment, packed  # held, so that no other takes its id
        return packed

    def _mesh(self, place: WebPlace) -> dict[str, Any]:
        """Pack a mesh."""
        looks = zip(place.names, place.colours, place.glass, strict=True)
        parts = [{"name": n, "colour": list(c), "glass": g} for n, c, g in looks]
        for part, state in zip(parts, place.state, strict=False):
            _put_state(part, state)
        return {
            "vertices": self._lengths(place.vertices, 3),
            "part": self._whole(place.part),
            "triangles": self._whole(place.triangles.ravel()),
            "edges": self._whole(place.edges.ravel()),
            "parts": parts,
        }

    def _body(self, body: WebBody) -> dict[str, Any]:
        names = [[k, name] for k, name in enumerate(body.spheres) if name]
        packed = {
            "name": body.name,
            "colour": list(body.colour),
            "ghost": body.ghost,
            "radius": self._lengths(body.radius, 1),
            "centres": self._lengths(body.centres.reshape(-1, 3), 3 * len(body.radius)),
            "segment": self._whole(body.segment),
            "segments": list(body.segments),
            "spheres": names,
            "failing": sorted(body.failing),
            "touching": [[s, *_milliseconds(span)] for s, *span in body.touching],
        }
        return _put_state(packed, body.state)

    def _gaps(self, gaps: WebGaps) -> dict[str, Any]:
        """Pack how near a motion comes; gaps that are not finite are far."""
        packed: dict[str, Any] = {
            "times": _milliseconds(gaps.times.tolist()),
            "least": self._lengths(np.nan_to_num(np.minimum(gaps.least, _FAR), nan=_FAR), 1),
            "words": gaps.words,
        }
        if gaps.asked is not None:
            asked = np.nan_to_num(np.minimum(gaps.asked, _FAR), nan=_FAR)
            packed |= {"asked": self._lengths(asked, 1), "limit": gaps.limit, "name": gaps.name}
        return packed

    def _lengths(self, values: Floats, stride: int) -> int:
        """Pack coordinates (M, 3) or radii (M,) [m]; returns the index of the array.

        Parameters
        ----------
        stride
            How many numbers before it the value stands from which the difference is written.
        """
        if not np.all(np.isfinite(values)):
            raise InputError("picture: coordinates must be finite")
        columns = np.atleast_2d(values.T).T
        low = columns.min(axis=0) if len(columns) else np.zeros(columns.shape[1])
        high = columns.max(axis=0) if len(columns) else low
        origin = np.round((low + high) / 2.0, 4)
        half = float(np.max(high - low, initial=0.0)) / 2.0 + TENTH
        step = FINE if half < 32_000 * FINE else TENTH
        kind = "<i2" if half < 32_000 * step else "<i4"
        steps = np.round((columns - origin) / step).astype(kind).ravel()
        return self._keep(steps, stride, {"step": step, "origin": [float(x) for x in origin]})

    def _whole(self, values: Ints) -> int:
        """Pack whole numbers that are not negative; returns the index of the array."""
        most = int(np.max(values, initial=0))
        kind = "<u1" if most < 1 << 8 else "<u2" if most < 1 << 16 else "<u4"
        return self._keep(values.astype(kind).ravel(), 1, {})

    def _keep(self, values: NDArray[Any], stride: int, more: dict[str, Any]) -> int:
        """Write an array as differences, byte by byte; one that is there already is not written
        again."""
        differences = values.copy()
        differences[stride:] -= values[:-stride]  # wraps around, and back when it is added up
        width = values.dtype.itemsize
        data = differences.view(np.uint8).reshape(-1, width).T.tobytes()
        kind = values.dtype.str.lstrip("<|")
        entry = {"kind": kind, "count": len(values), "stride": stride, **more}
        key = json.dumps(entry), data
        if key not in self._known:
            self._known[key] = len(self.arrays)
            self.arrays.append(_Array(entry, data))
        return self._known[key]


def _mark(mark: WebMark) -> dict[str, Any]:
    """A mark with its points rounded to a hundredth of a millimetre."""
    packed = {
        "from": _rounded(mark.point),
        "to": None if mark.to is None else _rounded(mark.to),
        "text": mark.text,
        "failing": mark.failing,
        "span": None if mark.span is None else _milliseconds(mark.span),
    }
    return _put_state(packed, mark.state)


def _put_state(packed: dict[str, Any], state: int | None) -> dict[str, Any]:
    """Say of which of two states something is; nothing where it is of both."""
    if state is not None:
        packed["state"] = state
    return packed


def _milliseconds(times: Sequence[float]) -> list[float]:
    return [round(1e3 * time, 3) + 0.0 for time in times]


def _rounded(point: Sequence[float]) -> list[float]:
    return [round(float(value), 5) + 0.0 for value in point]
