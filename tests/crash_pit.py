"""A pit with a floor and a wall, and a man somewhere in it: simulations small enough to check by
hand."""

from __future__ import annotations

BOX = [(1, 2, 3, 4), (8, 7, 6, 5), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 8, 4), (4, 8, 5, 1)]
SIMULATION = """simulation: pit_crash
length: mm
environment: pit
body: bubbleman
at: {segment: LT, position: [0, 0, 3000]}
posture: standing
pulse: {shape: half_sine, peak: 20, duration: 50}
gravity: 0
settle: 0
duration: 100
"""


def box(name, low, high, first):
    """A box of an OBJ file; `first`: how many vertices there are before."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    top = [(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)]
    corners = top + [(x, y, z0) for x, y, _ in top]
    lines = [f"o {name}", *(f"v {x} {y} {z}" for x, y, z in corners)]
    return (
        "\n".join([*lines, *("f " + " ".join(str(first + k) for k in face) for face in BOX)]) + "\n"
    )


def pit(folder, text=SIMULATION):
    """Write the pit and a simulation in it; returns the simulation's path."""
    place = folder / "environments/pit"
    place.mkdir(parents=True)
    mesh = box("floor", (-4, -4, -1), (4, 4, 0), 0) + box("wall", (1.5, -4, 0.1), (1.7, 4, 6), 8)
    (place / "pit.obj").write_text(mesh)
    (place / "environment.yaml").write_text(
        "environment: pit\nlength: mm\nmeshes: [{file: pit.obj, length: m, up: z, forward: x}]\n"
        "points: {post: [-500, 0, 3000]}\n"
    )
    (folder / "studies/simulations").mkdir(parents=True)
    path = folder / "studies/simulations/pit_crash.yaml"
    path.write_text(text)
    return path
