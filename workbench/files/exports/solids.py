"""Closed surfaces as files for other programs: binary STL and 3MF, in millimetres."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from workbench.model.arrays import Floats, Ints

__all__ = ["Surface", "stl_bytes", "threemf_bytes"]

Surface = tuple[Floats, Ints]  # corners (V, 3) [m], triangles (T, 3), outward

_TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
_RELATIONS = """<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="model" \
Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""
_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("none", "<u2")])
"""A triangle of an STL file; the last bytes are for attributes that nobody uses."""


def stl_bytes(surfaces: Mapping[str, Surface]) -> bytes:
    """Binary STL of all surfaces in turn, in millimetres; the names stand in the header as far as
    it reaches."""
    words = f"bubbleman-workbench, millimetres: {', '.join(surfaces)}"
    title = words.encode("ascii", "replace")[:80].ljust(80)
    facets = [_facets(points, triangles) for points, triangles in surfaces.values()]
    rows = np.concatenate([np.zeros(0, _FACET), *facets])
    return title + len(rows).to_bytes(4, "little") + rows.tobytes()


def _facets(points: Floats, triangles: Ints) -> NDArray[np.void]:
    """(T,) the triangles of a surface [m] as STL has them, in millimetres."""
    corners = 1000.0 * points[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    facets = np.zeros(len(triangles), _FACET)
    facets["normal"] = normal / np.where(length > 0.0, length, 1.0)
    facets["corners"] = corners
    return facets


def threemf_bytes(surfaces: Mapping[str, Surface]) -> bytes:
    """3MF (core specification) with one named object a surface, in millimetres."""
    numbered = list(enumerate(surfaces.items(), start=1))
    objects = "".join(_object(number, name, surface) for number, (name, surface) in numbered)
    items = "".join(f'<item objectid="{number}"/>' for number, _ in numbered)
    model = (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="millimeter" xmlns="{_CORE}"><resources>'
        f"{objects}</resources><build>{items}</build></model>\n"
    )
    files = {
        "[Content_Types].xml": _TYPES,
        "_rels/.rels": _RELATIONS,
        "3D/3dmodel.model": model,
    }
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, text in files.items():
            # no clock: the same bytes each time
            entry = zipfile.ZipInfo(path, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, text)
    return out.getvalue()


def _object(number: int, name: str, surface: Surface) -> str:
    """A surface as an object of the model."""
    points, triangles = surface
    corners = "".join(
        f'<vertex x="{x:.5f}" y="{y:.5f}" z="{z:.5f}"/>' for x, y, z in (1000.0 * points).tolist()
    )
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles.tolist())
    mesh = f"<mesh><vertices>{corners}</vertices><triangles>{faces}</triangles></mesh>"
    return f'<object id="{number}" type="model" name={quoteattr(_printable(name))}>{mesh}</object>'


def _printable(text: str) -> str:
    """Text without letters that XML forbids."""
    return "".join(
        letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in text
    )
