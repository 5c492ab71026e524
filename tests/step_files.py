"""Small STEP files, written by hand: boxes of flat facets in an assembly."""

from __future__ import annotations

import numpy as np

__all__ = ["step_assembly"]

_CORNERS = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


class _Lines:
    """Numbered entities."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def add(self, text: str) -> str:
        """Write an entity and return its number."""
        self.texts.append(text)
        return f"#{len(self.texts)}"


def step_assembly(parts: dict[str, tuple[str, ...]], *, size: float = 500.0) -> str:
    """An AP214 file [mm]: a product named `cab` that holds each product as often as it has names of
    occurrences ("" for one without), each `size` mm further along x."""
    lines = _Lines()
    add = lines.add
    application = add("APPLICATION_CONTEXT('automotive design')")
    product_context = add(f"PRODUCT_CONTEXT('',{application},'mechanical')")
    definition_context = add(
        f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')"
    )
    units = [
        add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))"),
        add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))"),
        add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())"),
    ]
    exact = add(
        f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-5),{units[0]},'distance_accuracy_value','')"
    )
    context = add(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)"
        f"GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({exact}))"
        f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({','.join(units)}))REPRESENTATION_CONTEXT('',''))"
    )
    z = add("DIRECTION('',(0.,0.,1.))")
    x = add("DIRECTION('',(1.,0.,0.))")

    def axes(along: float) -> str:
        point = add(f"CARTESIAN_POINT('',({along:.1f},0.,0.))")
        return add(f"AXIS2_PLACEMENT_3D('',{point},{z},{x})")

    def product(name: str, kind: str, items: list[str]) -> tuple[str, str]:
        one = add(f"PRODUCT('{name}','{name}','',({product_context}))")
        formation = add(f"PRODUCT_DEFINITION_FORMATION('','',{one})")
        definition = add(f"PRODUCT_DEFINITION('design','',{formation},{definition_context})")
        shape = add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
        drawn = add(f"{kind}('',({','.join(items)}),{context})")
        add(f"SHAPE_DEFINITION_REPRESENTATION({shape},{drawn})")
        return definition, drawn

    origin = axes(0.0)
    count = sum(map(len, parts.values()))
    places = [axes(2.0 * size * k) for k in range(count)]
    cab, whole = product("cab", "SHAPE_REPRESENTATION", [origin, *places])
    place = iter(places)
    for name, occurrences in parts.items():
        own = axes(0.0)
        made, drawn = product(name, "FACETED_BREP_SHAPE_REPRESENTATION", [own, _box(add, size)])
        for number, called in enumerate(occurrences):
            use = add(f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{number}','{called}','',{cab},{made},$)")
            shape = add(f"PRODUCT_DEFINITION_SHAPE('','',{use})")
            move = add(f"ITEM_DEFINED_TRANSFORMATION('','',{own},{next(place)})")
            link = add(
                f"(REPRESENTATION_RELATIONSHIP('','',{drawn},{whole})"
                f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({move})SHAPE_REPRESENTATION_RELATIONSHIP())"
            )
            add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({link},{shape})")
    body = "".join(f"#{k}={text};\n" for k, text in enumerate(lines.texts, start=1))
    return (
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
        f"FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n{body}ENDSEC;\nEND-ISO-10303-21;\n"
    )


def _box(add, size: float) -> str:  # type: ignore[no-untyped-def]
    """A closed box of six flat facets."""
    points = [
        add(f"CARTESIAN_POINT('',({x * size:.1f},{y * size:.1f},{z * size:.1f}))")
        for x, y, z in _CORNERS
    ]
    faces = []
    for corners in _FACES:
        loop = add(f"POLY_LOOP('',({','.join(points[c] for c in corners)}))")
        bound = add(f"FACE_OUTER_BOUND('',{loop},.T.)")
        a, b, c = (np.array(_CORNERS[k], dtype=float) for k in corners[:3])
        normal, along = (
            add(f"DIRECTION('',({d[0]:.1f},{d[1]:.1f},{d[2]:.1f}))")
            for d in (np.cross(b - a, c - b), b - a)
        )
        place = add(f"AXIS2_PLACEMENT_3D('',{points[corners[0]]},{normal},{along})")
        plane = add(f"PLANE('',{place})")
        faces.append(add(f"FACE_SURFACE('',({bound}),{plane},.T.)"))
    shell = add(f"CLOSED_SHELL('',({','.join(faces)}))")
    return add(f"FACETED_BREP('',{shell})")
