"""Closed surfaces as files for other programs: binary STL and 3MF, in millimetres."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from xml.sax.saxutils import quoteattr

import numpy as np

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


def stl_bytes(surfaces: Mapping[str, Surface]) -> bytes:
    """Binary STL of all surfaces in turn, in millimetres; the names stand in the header as far as
    it reaches."""
    title = (
        ("bubbleman-workbench, millimetres: " + ", ".join(surfaces))
        .encode("ascii", "replace")[:80]
        .ljust(80)
    )
    rows = np.zeros(
        sum(len(triangles) for _, triangles in surfaces.values()),
        dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("none", "<u2")],
    )
    at = 0
    for points, triangles in surfaces.values():
        corners = 1000.0 * points[triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        rows["normal"][at : at + len(triangles)] = normal / np.where(length > 0.0, length, 1.0)
        rows["corners"][at : at + len(triangles)] = corners
        at += len(triangles)
    return title + len(rows).to_bytes(4, "little") + rows.tobytes()


def threemf_bytes(surfaces: Mapping[str, Surface]) -> bytes:
    """3MF (core specification) with one named object a surface, in millimetres."""
    objects = []
    items = []
    for number, (name, (points, triangles)) in enumerate(surfaces.items(), start=1):
        corners = "".join(
            f'<vertex x="{x:.5f}" y="{y:.5f}" z="{z:.5f}"/>'
            for x, y, z in (1000.0 * points).tolist()
        )
        faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles.tolist())
        label = quoteattr(_printable(name))
        mesh = f"<mesh><vertices>{corners}</vertices><triangles>{faces}</triangles></mesh>"
        objects.append(f'<object id="{number}" type="model" name={label}>{mesh}</object>')
        items.append(f'<item objectid="{number}"/>')
    model = (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="millimeter" xmlns="{_CORE}"><resources>'
        f"{''.join(objects)}</resources><build>{''.join(items)}</build></model>\n"
    )
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, text in (
            ("[Content_Types].xml", _TYPES),
            ("_rels/.rels", _RELATIONS),
            ("3D/3dmodel.model", model),
        ):
            entry = zipfile.ZipInfo(
                path, (1980, 1, 1, 0, 0, 0)
            )  # no clock: the same bytes each time
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, text)
    return out.getvalue()


def _printable(text: str) -> str:
    """Text without letters that XML forbids."""
    return "".join(
        letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in text
    )
