"""Parts of a body from outlines: known shapes come back, bad files are told where."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import SHARED, needs_real_input
from workbench import InputError, decompose, sealed
from workbench.body.fitting.fit_quality import fit_quality
from workbench.body.outlines import outline_surface
from workbench.files.body.outlines import load_outlines
from workbench.files.meshes.reading import read_mesh
from workbench.model.outlines import Outlines, crossing

ADULT = SHARED / "bodies" / "makehuman_derived" / "adult_male.obj"
TURN = np.linspace(0, 2 * np.pi, 48, endpoint=False)
CIRCLE = np.column_stack([np.cos(TURN), np.sin(TURN)])
FOREARM = """
outlines: forearm
length: mm
axis: z
stations:
  - {at: 0, points: [[30, 0], [0, 30], [-30, 0], [0, -30]]}
  - {at: 10 cm, points: [[25, 0], [0, 30], [-25, 0], [0, -30], [25, 0]]}
"""


def stack(radii, step=0.02, axis=2, centre=(0, 0)):
    """Circles of these radii [m] at even steps."""
    return Outlines(
        "stack", axis, np.arange(len(radii)) * step, tuple(r * CIRCLE + centre for r in radii)
    )


def test_equal_circles_give_a_cylinder():
    made = outline_surface(stack([0.05] * 6), pitch=0.003)
    assert made.volume == pytest.approx(np.pi * 0.05**2 * 0.1, rel=0.01)
    assert made.distance([[0, 0, 0.05], [0.06, 0, 0.05], [0, 0, 0.11]]) == pytest.approx(
        [-0.05, 0.01, 0.01], abs=5e-4
    )


def test_circles_of_a_ball_give_the_ball_between_the_slices_too():
    z = np.linspace(-0.0999, 0.0999, 21)
    made = outline_surface(
        Outlines("ball", 2, z, tuple(np.sqrt(0.01 - h * h) * CIRCLE for h in z)), pitch=0.003
    )
    assert np.abs(np.linalg.norm(made.vertices, axis=1) - 0.1).mean() < 7e-4


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_axis_turns_the_part(axis):
    made = outline_surface(stack([0.03] * 4, axis=axis, centre=(0.1, 0)), pitch=0.003)
    middle = made.vertices.mean(axis=0)
    assert middle[axis] == pytest.approx(0.03, abs=2e-3) and middle[
        (axis + 1) % 3
    ] == pytest.approx(0.1, abs=2e-3)


def test_two_curves_of_a_station_are_two_limbs_and_one_in_another_is_a_hole():
    station = np.repeat([0.0, 0.05, 0.1], 2)
    legs = outline_surface(
        Outlines("legs", 2, station, (0.03 * CIRCLE, 0.03 * CIRCLE + [0.1, 0]) * 3), pitch=0.003
    )
    tube = outline_surface(
        Outlines("tube", 2, station, (0.04 * CIRCLE, 0.02 * CIRCLE) * 3), pitch=0.003
    )
    assert (
        legs.distance([[0, 0, 0.05], [0.1, 0, 0.05]]).max() < -0.02
        and legs.distance([[0.05, 0, 0.05]])[0] > 0.01
    )
    assert tube.distance([[0, 0, 0.05]])[0] > 0.01 and tube.distance([[0.03, 0, 0.05]])[0] < -0.005


def test_a_file_gives_metres_in_order(tmp_path):
    path = tmp_path / "forearm.yaml"
    path.write_text(FOREARM)
    read = load_outlines(path)
    assert read.name == "forearm" and read.axis == 2 and read.station.tolist() == [0, 0.1]
    assert len(read.points[1]) == 4 and read.points[1][0] == pytest.approx([0.025, 0])


def test_spheres_from_outlines_keep_the_tolerance():
    made = outline_surface(stack([0.03, 0.035, 0.034, 0.028, 0.024, 0.022]), pitch=0.004)
    fit = decompose(made, outward=0.004, inward=0.004, least_radius=0.002, greatest_radius=0.1)
    found = fit_quality(made, fit.centre, fit.radius)
    assert found.inside <= 0.004 + 1e-9 and found.to_surface <= 0.004 + 1e-9 and found.mean < 0.0025


@pytest.mark.parametrize(
    "old, new, said",
    [
        (
            "[0, 30], [-30, 0]",
            "[-30, 0], [0, 30]",
            r":6:\d+: stations\[0\].points\[\d\]: the curve crosses itself here",
        ),
        ("axis: z", "axis: w", r":4:1: axis: "),
        ("length: mm", "", r"length: the unit of length is needed"),
        ("at: 10 cm", "at: 0", r":5:1: stations: outlines at two stations"),
        (
            "[30, 0], [0, 30], [-30, 0], [0, -30]]}\n",
            "[30, 0], [0, 30]]}\n",
            r":6:\d+: .*at least 3 are needed",
        ),
        ("[25, 0], [0, 30]", "[25, 0, 1], [0, 30]", r":7:\d+: "),
        ("points: [[25", "point: [[25", r"unknown key 'point'; did you mean 'points'"),
    ],
)
def test_a_bad_file_is_told_with_its_place(tmp_path, old, new, said):
    path = tmp_path / "bad.yaml"
    assert old in FOREARM
    path.write_text(FOREARM.replace(old, new, 1))
    with pytest.raises(InputError, match=said):
        load_outlines(path)


def test_one_section_is_a_slab_or_turns_to_a_body_of_rotation(tmp_path):
    """A 60 x 60 mm rhomb 40 mm thick is 0.5 x 60 x 60 x 40 mm3, a cone frustum pi h (R2 + Rr + r2) / 3."""
    path = tmp_path / "one.yaml"
    one = FOREARM[: FOREARM.index("  - {at: 10 cm")]
    path.write_text(one + "thickness: 40\n")
    slab = outline_surface(load_outlines(path), pitch=0.001)
    assert slab.volume == pytest.approx(0.5 * 0.06 * 0.06 * 0.04, rel=0.02)
    assert slab.vertices[:, 2].min() == pytest.approx(-0.02, abs=1e-3)
    path.write_text(one[: one.index("stations")] + "lathe: [[0, 30], [100, 20]]\n")
    cone = outline_surface(load_outlines(path), pitch=0.001)
    assert cone.volume == pytest.approx(np.pi * 0.1 * (0.0009 + 0.0006 + 0.0004) / 3, rel=0.02)
    for text, said in (
        (one, r":5:1: stations: .*slab \(thickness.*lathe"),
        (one + "lathe: [[0, 30], [100, 20]]\n", "a lathe has no stations"),
        (FOREARM + "thickness: 40\n", "a slab has one station"),
        (one[: one.index("stations")] + "lathe: [[10, 30], [0, 20]]\n", "places rising"),
    ):
        path.write_text(text)
        with pytest.raises(InputError, match=said):
            load_outlines(path)


def test_curves_of_one_station_that_cross_are_refused(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text(FOREARM + "  - {at: 100, points: [[40, 0], [10, 10], [10, -10]]}\n")
    said = r":8:\d+: stations\[2\].points\[\d\]: the curve crosses the curve of stations\[1\]"
    with pytest.raises(InputError, match=said):
        load_outlines(path)
    with pytest.raises(InputError, match="crosses outline 1"):
        Outlines("made", 2, np.array([0.0, 0, 1]), (CIRCLE, CIRCLE + 0.5, CIRCLE))


def test_a_figure_of_eight_crosses_itself_and_a_square_does_not():
    eight = np.array([[0, 0], [1, 1], [1, 0], [0, 1.0]])
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    assert crossing(eight, eight) is not None and crossing(square, square) is None
    assert crossing(square, square + 0.5) is not None and crossing(square, square + 2) is None


def test_a_grid_too_large_is_refused_with_what_is_possible():
    with pytest.raises(InputError, match=r"a pitch of .* mm or more is possible"):
        outline_surface(stack([0.05] * 6), pitch=1e-4)


@pytest.mark.nightly
@needs_real_input(ADULT)
def test_a_trunk_sliced_every_20_mm_comes_back():
    part = read_mesh(ADULT).parts[0]
    whole = sealed(part.vertices[:, [2, 0, 1]] * (1.756 / np.ptp(part.vertices[:, 1])), part.faces)
    made = outline_surface(slices(whole, np.arange(0.04, 0.26, 0.02)), pitch=0.004)
    between = made.vertices[
        (np.abs((made.vertices[:, 2] % 0.02) - 0.01) < 0.003)
        & (made.vertices[:, 2] > 0.05)
        & (made.vertices[:, 2] < 0.23)
    ]
    assert np.abs(whole.distance(between)).mean() < 1.5e-3


def slices(surface, heights):
    """Outlines of the trunk of a body at some heights [m] (the piece nearest to the middle)."""
    import trimesh

    mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    loops = []
    for z in heights:
        rings = [np.asarray(r)[:-1, :2] for r in mesh.section([0, 0, 1], [0, 0, z]).discrete]
        loops.append(min(rings, key=lambda r: np.abs(r[:, 1].mean())))
    return Outlines("trunk", 2, heights, tuple(loops))
