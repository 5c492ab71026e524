"""Which part has an inside: windings mended and reported, shells in shells, open parts around
people, copies."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import workbench as wb
from tests.conftest import BOX_FACES, ROOT, SHARED, box_part, environment_of, real_input
from tests.made_studies import found_of, made_study
from tests.oracles import point_triangle, winding
from tests.test_crash import BODY
from tests.test_crash import STUDY as CRASH
from tests.test_crash import standing as dropped
from tests.test_real_inputs import BALL, FILES
from tests.toy_cockpit import write_toy
from workbench import InputError, environment_from_mesh, load_study
from workbench.cli import main
from workbench.files.mesh_report import inspect_mesh
from workbench.files.meshes.assembly import build_environment
from workbench.files.meshes.mesh_validation import validate_part
from workbench.files.meshes.parts import RawPart, weld
from workbench.files.meshes.reading import read_mesh, to_world
from workbench.files.motions.tables import angle_table_text
from workbench.files.postures import posture_pose
from workbench.model.criterion import Criterion
from workbench.model.workplace import Stand

LOW = [-1.5, -1.5, -0.5]
HIGH = [1.5, 1.5, 2.5]


def turned(part, rows):
    """The part with some faces wound the other way."""
    faces = part.faces.copy()
    faces[rows] = faces[rows][:, ::-1]
    return RawPart(part.name, part.vertices, faces)


def without(part, rows):
    return RawPart(part.name, part.vertices, np.delete(part.faces, rows, axis=0))


def together(name, *parts):
    """Several parts as one, equal places one vertex."""
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = np.concatenate([part.faces + start for part, start in zip(parts, first, strict=False)])
    return RawPart(name, *weld(np.concatenate([part.vertices for part in parts]), faces))


def weld_row(vertices, point):
    """The row of a point among vertices (V, 3)."""
    return int(np.flatnonzero((vertices == point).all(axis=1))[0])


def box(low, high, *, inward=False):
    part = box_part("box", low, high)
    return turned(part, np.arange(12)) if inward else part


def written(path, part):
    lines = [f"o {part.name}", *("v {:.9g} {:.9g} {:.9g}".format(*v) for v in part.vertices)]
    path.write_text(
        "\n".join([*lines, *("f {} {} {}".format(*(f + 1)) for f in part.faces)]) + "\n"
    )
    return path


@cache
def ball():
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "ball.yaml"
        file.write_text(BALL)
        return wb.load_body(file)


def distances(environment, points):
    """(P, K) signed distance of points (P, 3) to each part."""
    points = np.asarray(points, dtype=float)
    world = np.concatenate(
        [np.broadcast_to(np.eye(3), (len(points), 3, 3)), points[:, :, None]], axis=2
    )
    placed = wb.place(ball(), wb.Poses(np.zeros((len(points), 0, 4)), 0, world))
    return wb.clearance(placed, environment)[:, 0] + 0.05


def slow_distance(part, point):
    """Signed distance of a point to a part, triangle by triangle; inside by the winding number."""
    corners = part.vertices[part.faces]
    gap = min(point_triangle(point, corner) for corner in corners)
    return -gap if abs(winding(point, corners)) > 0.5 else gap


@cache
def closed_parts(most, *names):
    """The closed parts of shipped environments with at most so many faces."""
    meshes = [ROOT / "environments" / name / f"{name}.obj" for name in names]
    parts = [part for path in meshes for part in read_mesh(path).parts if len(part.faces) <= most]
    return tuple(part for part in parts if validate_part(part)[1].closed)


def check_flips(good, rows, rng, *, points=4):
    """A mesh with faces turned the wrong way is the good mesh after mending: names, polygons and
    signed distances."""
    mended, found = validate_part(turned(good, rows))
    right, before = validate_part(good)
    assert found.closed
    assert (
        found.against == min(len(rows), len(good.faces) - len(rows))
        or before.cavities
        or before.crossing
    )
    bad_one = environment_of(turned(good, rows))
    good_one = environment_of(good)
    assert bad_one.parts == good_one.parts
    assert bad_one.part_start.tolist() == good_one.part_start.tolist()
    np.testing.assert_array_equal(bad_one.edge_start, good_one.edge_start)
    np.testing.assert_allclose(bad_one.normal, good_one.normal, atol=1e-12)
    assert [set(face) for face in mended.faces.tolist()] == [
        set(face) for face in right.faces.tolist()
    ]
    low, high = good_one.bounds
    places = rng.uniform(low - 0.05, high + 0.05, (50, 3))
    np.testing.assert_allclose(distances(bad_one, places), distances(good_one, places), atol=1e-12)
    for place in places[:points]:
        assert distances(bad_one, place[None]).item() == pytest.approx(
            slow_distance(right, place), abs=2e-6
        )


@settings(max_examples=12)
@given(st.data())
def test_any_faces_of_a_shipped_part_turned_round_leave_every_signed_distance_as_it_was(data):
    good = data.draw(st.sampled_from(closed_parts(120, "compact_car")))
    found = validate_part(good)[1]
    assert found.cavities == 0
    rows = data.draw(
        st.sets(st.integers(0, len(good.faces) - 1), min_size=1, max_size=len(good.faces))
    )
    check_flips(good, sorted(rows), np.random.default_rng(len(rows)), points=1)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["wheelchair_hulls", "truck", "suv", "bench"])
def test_any_faces_of_a_real_part_turned_round_leave_every_signed_distance_as_it_was(name):
    file = FILES[name]
    path = real_input(SHARED / "environments" / file.path)
    rng = np.random.default_rng(3)
    closed = [
        part
        for part in to_world(read_mesh(path), np.eye(3), metres=file.metres)
        if validate_part(part)[1].closed
    ]
    assert closed
    for part in closed:
        for _ in range(25):
            count = int(rng.integers(1, max(len(part.faces) // 8, 2)))
            check_flips(part, rng.choice(len(part.faces), count, replace=False), rng, points=1)


@pytest.mark.nightly
def test_any_faces_of_any_shipped_part_turned_round_leave_every_signed_distance_as_it_was():
    rng = np.random.default_rng(4)
    for part in closed_parts(5000, "trainer", "compact_car"):
        for _ in range(3):
            rows = rng.choice(
                len(part.faces), int(rng.integers(1, len(part.faces) // 4)), replace=False
            )
            check_flips(part, rows, rng, points=1)


def standing(bubbleman, postures, environment, *, at=(0.0, 0.0, 0.0)):
    """A study of a man who stands at a place; he must be clear of everything."""
    pose = posture_pose(bubbleman, postures, "standing")
    clear = Criterion(
        "clear", "clearance", ("man",), tuple(bubbleman.segments), environment.parts, 0.0
    )
    man = {"man": ({"body": bubbleman, "stand": Stand(at)}, pose)}
    return made_study(environment, man, [clear], case="standing")


def test_a_man_inside_a_block_fails_as_deep_with_two_triangles_turned_round(bubbleman, postures):
    good = box_part("block", LOW, HIGH)
    bad = turned(good, [3, 8])
    results = [
        found_of(standing(bubbleman, postures, environment_of(part))) for part in (good, bad)
    ]
    assert [result.passed for result in results] == [False, False]
    depths = [result.people[0].clearance.distance.min() for result in results]
    assert depths[1] == pytest.approx(depths[0], abs=1e-12)
    assert depths[0] < -0.5
    assert environment_of(bad).warnings == (
        "part block: 2 faces wound against neighbours: turned; nothing that is found depends on it",
    )


def test_a_mended_winding_is_marked_in_the_inspection(tmp_path, capsys):
    path = written(tmp_path / "block.obj", turned(box_part("block", LOW, HIGH), [0, 5]))
    assert main(["inspect", str(path), "--units", "m"]) == 0
    text = capsys.readouterr().out
    assert "2 faces wound against neighbours: turned" in text
    assert "* wound inside out, or not all alike; turned" in text
    (part,) = inspect_mesh(path, length="m").parts
    assert (part.solid, part.watertight, part.against, part.open_edges) == (True, True, 2, 0)


def strip(count, *, closed_tube=False):
    """A Moebius strip of width 0.4; or a tube closed on itself the wrong way round (a Klein
    bottle)."""
    around = np.linspace(0, 2 * np.pi, count, endpoint=False)
    if closed_tube:
        across = np.linspace(0, 2 * np.pi, 8, endpoint=False)
        half, spin = np.meshgrid(around / 2, across, indexing="ij")
        radius = 2 + np.cos(half) * np.sin(spin) - np.sin(half) * np.sin(2 * spin)
        height = np.sin(half) * np.sin(spin) + np.cos(half) * np.sin(2 * spin)
        points = np.stack([radius * np.cos(2 * half), radius * np.sin(2 * half), height], axis=-1)
        ring = 8
        rows = range(8)
    else:
        side = np.array([-0.2, 0.2])
        half = around[:, None] / 2
        radius = 1 + side * np.cos(half)
        points = np.stack(
            [radius * np.cos(2 * half), radius * np.sin(2 * half), side * np.sin(half)], axis=-1
        )
        ring = 2
        rows = range(1)
    faces = []
    for k in range(count):
        for j in rows:
            here = [k * ring + j, k * ring + (j + 1) % ring]
            if k < count - 1:
                there = [(k + 1) * ring + j, (k + 1) * ring + (j + 1) % ring]
            else:  # joined the other way round
                there = [(-j) % ring, (-j - 1) % ring] if closed_tube else [1, 0]
            faces += [[here[0], there[0], here[1]], [here[1], there[0], there[1]]]
    return RawPart("strip", points.reshape(-1, 3), np.array(faces))


def test_a_moebius_strip_is_an_open_surface_with_one_side():
    kept, found = validate_part(strip(40))
    assert (found.one_sided, found.closed, found.open_edges) == (1, False, 80)
    assert "1 patch with one side only, as a Moebius strip has" in found.sentences()
    np.testing.assert_array_equal(kept.faces, strip(40).faces)


def test_a_klein_bottle_has_no_open_edge_and_is_a_surface_all_the_same():
    found = validate_part(strip(24, closed_tube=True))[1]
    assert (found.one_sided, found.closed, found.open_edges) == (1, False, 0)
    assert any(
        "one side only" in line and "a surface, not a solid" in line for line in found.sentences()
    )
    _, faults = build_environment("a", [strip(24, closed_tube=True)], solid=[True])
    assert "one side only" in faults[0][1]


def test_a_box_with_a_fin_is_reported_as_a_surface_although_no_edge_is_without_a_partner():
    """Four faces at an edge of which two lie on both sides of a sheet: no winding makes them
    pairs."""
    vertices = np.vstack([box_part("b", LOW, HIGH).vertices, [[0, 0, 4.0]]])
    fin = RawPart("finned", vertices, np.vstack([BOX_FACES, [[1, 7, 8]]]))
    found = validate_part(fin)[1]
    assert not found.closed
    assert any("a surface, not a solid" in line for line in found.sentences())


def test_the_wall_between_two_boxes_that_touch_is_no_hole_in_them():
    """Both have the wall, wound opposite ways; together they are one solid."""
    both = together("pair", box([0, 0, 0], [1, 1, 1]), box([1, 0, 0], [2, 1, 1]))
    made, found = validate_part(both)
    assert (found.closed, found.duplicate, len(made.faces)) == (True, 4, 20)
    at = distances(environment_of(both), [[0.5, 0.5, 0.5], [1.0, 0.5, 0.5], [2.5, 0.5, 0.5]])[:, 0]
    assert at == pytest.approx([-0.5, -0.5, 0.5])


@pytest.mark.parametrize(
    ("inner_inward", "outer_inward", "in_the_middle", "counts"),
    [
        (False, False, True, (0, 0, 1)),
        (True, False, False, (0, 1, 0)),
        (False, True, False, (2, 1, 0)),
        (True, True, True, (2, 0, 1)),
    ],
)
def test_a_shell_in_a_shell_is_a_cavity_where_wound_opposite_and_else_part_of_the_solid(
    inner_inward, outer_inward, in_the_middle, counts
):
    both = together(
        "nest",
        box([0, 0, 0], [3, 3, 3], inward=outer_inward),
        box([1, 1, 1], [2, 2, 2], inward=inner_inward),
    )
    found = validate_part(both)[1]
    assert (found.turned, found.cavities, found.nested) == counts
    at = distances(environment_of(both), [[1.5, 1.5, 1.5], [0.4, 1.5, 1.5], [-0.4, 1.5, 1.5]])[:, 0]
    assert at == pytest.approx([-1.5 if in_the_middle else 0.5, -0.4, 0.4])


def test_an_island_in_a_cavity_is_solid_again():
    shells = [box([0] * 3, [5] * 3), box([1] * 3, [4] * 3, inward=True), box([2] * 3, [3] * 3)]
    found = validate_part(together("nest", *shells))[1]
    assert (found.turned, found.cavities, found.nested) == (0, 1, 0)


def test_a_shell_inside_out_beside_another_is_no_cavity_although_it_lies_within_its_box():
    """Two bars make an L; a cube in the L's open corner lies in its box and not in it."""
    bars = [box([0, 0, 0], [4, 1, 1]), box([0, 1, 0], [1, 4, 1])]
    found = validate_part(together("corner", *bars, box([2, 2, 0.1], [3, 3, 0.9], inward=True)))[1]
    assert (found.turned, found.cavities) == (1, 0)


@pytest.mark.parametrize("inward", [False, True])
def test_shells_that_cross_are_one_solid_and_counted(inward):
    both = together(
        "cross",
        box([-2, -0.5, -0.5], [2, 0.5, 0.5]),
        box([-0.5, -2, -0.5], [0.5, 2, 0.5], inward=inward),
    )
    found = validate_part(both)[1]
    assert (found.crossing, found.turned, found.closed) == (2, int(inward), True)
    assert distances(environment_of(both), [[0, 0, 0.1], [1, 0, 0.1], [1, 1, 0]])[
        :, 0
    ] == pytest.approx([-0.4, -0.4, 0.5])


def test_a_shell_that_crosses_itself_is_counted():
    """A bow tie: an outline like an 8, one loop wound one way and the other loop the other way."""
    outline = np.array([[0, 0], [2, 2], [2, 0], [0, 2.0]])
    low = np.column_stack([outline, np.zeros(4)])
    high = np.column_stack([outline, np.ones(4)])
    sides = [[[k, (k + 1) % 4, k + 4], [(k + 1) % 4, (k + 1) % 4 + 4, k + 4]] for k in range(4)]
    caps = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]]
    part = RawPart(
        "tie", np.vstack([low, high]), np.array([*np.reshape(sides, (8, 3)).tolist(), *caps])
    )
    found = validate_part(part)[1]
    assert (found.closed, found.crossing) == (True, 1)


def test_a_depth_in_a_solid_that_crosses_itself_is_called_a_lower_bound(bubbleman, postures):
    """Two boxes 2 m long joined to one shell that crosses itself; the man's feet are in both."""
    low, high = [-1, -1, -0.5], [1, 1, 1]
    one, other = box_part("one", low, high), box_part("other", [-0.5, -2, -0.4], [0.5, 2, 0.9])
    split = without(one, [0]), without(other, [0])
    part = together("knot", *split)
    a = [weld_row(part.vertices, one.vertices[k]) for k in one.faces[0]]
    b = [weld_row(part.vertices, other.vertices[k]) for k in other.faces[0]]
    tube = [[a[i], a[(i + 1) % 3], b[-i]] for i in range(3)]
    tube += [[a[(i + 1) % 3], b[-(i + 1) % 3], b[-i]] for i in range(3)]
    knot = RawPart("knot", part.vertices, np.vstack([part.faces, tube]))
    environment = environment_of(knot)
    assert environment.quality[0].tangled == 1
    (said,) = [
        line
        for line in found_of(standing(bubbleman, postures, environment)).warnings
        if "a lower bound, since" in line
    ]
    assert "at least" in said and "'knot'" in said


def hand_depth(bubbleman, postures, part):
    """[mm] How deep a study finds the right hand of a standing man in a part, and its verdict when
    30 mm are allowed."""
    study = standing(bubbleman, postures, environment_of(part))
    asked = Criterion("hand", "contact", ("man",), ("RHN",), (part.name,), 0.0, at_most=0.03)
    found = found_of(replace(study, criteria=(asked,)))
    return -1000 * found.verdicts[0].worst.value, found.passed


def around_hand(bubbleman, postures, *, wall=0.0, inward=False):
    """A block that ends 100 mm above the middle of that hand and 200 mm below it."""
    empty = standing(bubbleman, postures, environment_of(box_part("far", [8, 8, 8], [9, 9, 9])))
    placed = found_of(empty).people[0].placed
    middle = placed.world_from_segment[0, bubbleman.segment("RHN"), :, 3]
    low = middle - np.array([0.25, 0.15, 0.2]) + wall
    high = middle + np.array([0.25, 0.15, 0.1]) - wall
    return box(low, high, inward=inward)


def faces_toward(part, axis, sign):
    """The two triangles of a box on one side of it."""
    side = part.vertices[part.faces][:, :, axis]
    wanted = side.max() if sign > 0 else side.min()
    return np.flatnonzero((side == wanted).all(axis=1))


def test_a_hand_through_the_wall_of_an_open_box_is_as_deep_as_in_a_closed_one(bubbleman, postures):
    block = around_hand(bubbleman, postures)
    closed = hand_depth(bubbleman, postures, block)
    assert closed[0] > 50 and not closed[1]
    front = faces_toward(block, 0, 1)
    for missing in (front, front[:1]):
        depth = hand_depth(bubbleman, postures, without(block, missing))
        assert depth == (pytest.approx(closed[0], abs=1e-6), False)


def test_a_hand_that_enters_a_box_by_its_opening_is_in_nothing(bubbleman, postures):
    block = around_hand(bubbleman, postures)
    tray = without(block, faces_toward(block, 2, 1))
    depth, passed = hand_depth(bubbleman, postures, tray)
    assert passed and depth < 0


def test_a_hand_in_the_cavity_of_an_open_double_wall_is_as_in_that_of_a_closed_one(
    bubbleman, postures
):
    outer = around_hand(bubbleman, postures, wall=-0.05)
    inner = around_hand(bubbleman, postures, wall=-0.02, inward=True)
    closed = hand_depth(bubbleman, postures, together("box", outer, inner))
    opened = [without(part, faces_toward(part, 0, 1)) for part in (outer, inner)]
    assert hand_depth(bubbleman, postures, together("box", *opened)) == (
        pytest.approx(closed[0], abs=1e-6),
        closed[1],
    )


cuts = st.lists(st.integers(1, 9), min_size=1, max_size=3, unique=True).map(sorted)
shares = st.tuples(*[st.integers(0, 9)] * 3)


def block_distance(points, size):
    """Signed distance (Q,) of points to a box from 0 to size."""
    beyond = np.abs(points - size / 2) - size / 2
    return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)


@settings(deadline=None, max_examples=25)
@given(
    cuts=cuts,
    overlap=st.sampled_from([0.0, 0.001, 0.03]),
    inserts=st.lists(st.tuples(shares, shares), max_size=2),
    turn=st.sampled_from([0.0, 0.3, 1.1]),
    seed=st.integers(0, 99),
)
def test_a_block_and_any_cut_of_it_into_solids_give_the_same_signed_distances(
    cuts, overlap, inserts, turn, seed
):
    """Slices across x that overlap or touch, and solids within, some with walls in common."""
    size = np.array([0.5, 0.4, 0.3])
    ends = [0, *(0.05 * cut for cut in cuts), 0.5]
    pieces = [
        box([low, 0, 0], [min(high + overlap, 0.5), 0.4, 0.3]) for low, high in pairwise(ends)
    ]
    for one, other in inserts:
        low = np.minimum(one, other)
        pieces.append(box(size * low / 10, size * (np.maximum(one, other) + 1) / 10))
    rotation = np.array(
        [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    )
    cut = together("block", *pieces)
    cut = RawPart("block", cut.vertices @ rotation.T, cut.faces)
    points = size * np.random.default_rng(seed).uniform(-0.2, 1.2, (20, 3))
    environment = environment_of(cut)
    assert environment.solid[0] and not environment.tangled
    found = distances(environment, points @ rotation.T)[:, 0]
    assert found == pytest.approx(block_distance(points, size), abs=1e-9)


def other_diagonals(part):
    """The box with its sides cut along their other diagonals."""
    made = []
    for one, other in part.faces.reshape(6, 2, 3):
        at = int(np.flatnonzero(~np.isin(one, other))[0])
        tip, first, last = np.roll(one, -at)
        far = int(other[~np.isin(other, one)][0])
        made += [[tip, first, far], [tip, far, last]]
    return RawPart(part.name, part.vertices, np.array(made))


@settings(deadline=None, max_examples=15)
@given(
    cuts=cuts,
    which=st.integers(0, 15),
    turn=st.tuples(*[st.floats(-3, 3)] * 3),
    decimals=st.sampled_from([None, 6, 5, 4]),
    seed=st.integers(0, 99),
)
def test_solids_whose_common_walls_are_cut_and_rounded_each_in_its_way_are_one_block(
    cuts, which, turn, decimals, seed
):
    """Corners of single precision, or with so many decimals of a metre."""
    size = np.array([0.5, 0.4, 0.3])
    ends = [0, *(0.05 * cut for cut in cuts), 0.5]
    pieces = [box([low, 0, 0], [high, 0.4, 0.3]) for low, high in pairwise(ends)]
    pieces = [other_diagonals(p) if which >> k & 1 else p for k, p in enumerate(pieces)]
    cut = together("block", *pieces)
    rotation = Rotation.from_rotvec(turn).as_matrix()
    vertices = cut.vertices @ rotation.T + [3, -2, 1]
    vertices = vertices.astype(np.float32) if decimals is None else vertices.round(decimals)
    environment = environment_of(RawPart("block", vertices.astype(float), cut.faces))
    assert environment.solid[0] and not environment.tangled
    points = size * np.random.default_rng(seed).uniform(0, 1, (10, 3))
    found = distances(environment, points @ rotation.T + [3, -2, 1])[:, 0]
    digits = 4e-6 if decimals is None else 8 * 10.0**-decimals
    assert found == pytest.approx(block_distance(points, size), abs=digits)


def test_solids_of_a_part_that_are_apart_keep_their_faces_and_surfaces_are_not_united():
    apart = together("apart", box([0, 0, 0], [1, 1, 1]), box([2, 0, 0], [3, 1, 1]))
    assert np.array_equal(validate_part(apart)[0].faces, apart.faces)
    over = together("over", box([0, 0, 0], [2, 1, 1]), box([1, 0.2, 0.2], [3, 0.8, 0.8]))
    assert np.array_equal(validate_part(over, solid=False)[0].faces, over.faces)
    made = [validate_part(over)[0] for _ in range(2)]
    assert made[0].vertices.tobytes() == made[1].vertices.tobytes()
    assert made[0].faces.tobytes() == made[1].faces.tobytes()


@pytest.mark.parametrize("face", range(6))
def test_a_man_in_a_block_with_one_face_missing_is_reported(bubbleman, postures, face):
    block = without(box_part("block", LOW, HIGH), [2 * face, 2 * face + 1])
    (said,) = [
        line
        for line in found_of(standing(bubbleman, postures, environment_of(block))).warnings
        if "enclosed" in line
    ]
    assert said.startswith("man, standing: the body is enclosed by the open part 'block'")


@pytest.mark.parametrize(
    "parts",
    [
        [without(turned(box_part("block", LOW, HIGH), [1, 6, 9]), [3])],
        [RawPart("block", box_part("b", LOW, HIGH).vertices, np.vstack([BOX_FACES, [[0, 3, 7]]]))],
    ],
    ids=["wound unevenly and open", "with an inner wall"],
)
def test_a_man_in_a_block_of_undetermined_winding_is_reported(bubbleman, postures, parts):
    warnings = found_of(standing(bubbleman, postures, environment_of(*parts))).warnings
    assert any("enclosed by the open part 'block'" in line for line in warnings)


def test_nobody_is_reported_in_a_cabin_that_is_declared_not_to_be_solid(bubbleman, postures):
    for cabin in (box_part("cabin", LOW, HIGH), without(box_part("cabin", LOW, HIGH), [4])):
        result = found_of(standing(bubbleman, postures, environment_of(cabin, solid=False)))
        assert not [
            line for line in result.warnings if "enclosed" in line or "inside" in line.split(":")[0]
        ]
        assert result.passed


def test_nobody_is_reported_beside_an_open_block_in_a_bowl_or_between_double_walls(
    bubbleman, postures
):
    block = without(box_part("block", LOW, HIGH), [0, 1])
    beside = found_of(standing(bubbleman, postures, environment_of(block), at=(4.0, 0.0, 0.0)))
    low_bowl = without(box_part("bowl", [-1, -1, -0.2], [1, 1, 0.2]), [10, 11])
    bowl = found_of(standing(bubbleman, postures, environment_of(low_bowl)))
    walls = together("walls", box([-1.6, -1.6, -0.6], [1.6, 1.6, 2.6]), box(LOW, HIGH, inward=True))
    room = found_of(standing(bubbleman, postures, environment_of(without(walls, [0]))))
    for result in (beside, bowl, room):
        assert not [line for line in result.warnings if "enclosed" in line]


def test_an_open_part_around_a_man_is_reported_by_check_run_and_the_page(tmp_path, capsys):
    block = without(box_part("block", [-1.5, -1.5, -0.2], [1.5, 1.5, 2.5]), [3, 8])
    written(tmp_path / "block.obj", block)
    (tmp_path / "environment.yaml").write_text(
        "environment: hall\nlength: mm\nmeshes: [{file: block.obj, length: m, up: z, forward: x}]\n"
    )
    study = tmp_path / "inside.yaml"
    study.write_text(
        "study: inside\nlength: mm\nenvironment: environment.yaml\n"
        "people:\n  man: {body: bubbleman, stand: {on: [0, 0, 0]}}\n"
        "cases:\n  - {name: still, people: {man: {posture: standing}}}\n"
        "criteria:\n  - {name: clear, check: clearance, at_least: 0}\n"
    )
    assert main(["check", str(tmp_path / "environment.yaml")]) == 0
    assert "a surface, not a solid" in capsys.readouterr().err
    assert main(["run", str(study), "--out", str(tmp_path / "out")]) in (0, 1)
    said = capsys.readouterr().err
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for text in (said, page):
        assert "a surface, not a solid" in text
        assert "the body is enclosed by the open part" in text


def test_an_accommodation_study_reports_an_open_part_around_the_people(tmp_path):
    path = write_toy(tmp_path, people=2)
    place = tmp_path / "environments" / "toy"
    written(place / "hall.obj", without(box_part("hall", [-1, -1, -0.5], [2.5, 1, 2]), [0]))
    text = (place / "environment.yaml").read_text()
    more = (
        "toy.obj, length: mm, up: z, forward: x}, {file: hall.obj, length: m, up: z, forward: x}]"
    )
    (place / "environment.yaml").write_text(
        text.replace("toy.obj, length: mm, up: z, forward: x}]", more)
    )
    said = wb.run(load_study(path)).population.warnings
    assert any("the body is enclosed by the open part 'hall'" in line for line in said)


def test_a_crash_study_reports_an_open_part_around_the_person(tmp_path):
    time = np.array([0.0, 0.05, 0.1])
    (tmp_path / "drop.csv").write_text(
        "".join(angle_table_text(BODY, dropped(np.array([0.1, 0.05, 0.0]), time)))
    )
    written(tmp_path / "hall.obj", without(box_part("hall", [-1, -1, -0.5], [1, 1, 3]), [0]))
    (tmp_path / "environment.yaml").write_text(
        "environment: hall\nlength: mm\nmeshes: [{file: hall.obj, length: m, up: z, forward: x}]\n"
    )
    path = tmp_path / "drop.yaml"
    path.write_text(CRASH.replace("environment: pit", "environment: environment.yaml"))
    said = wb.run(wb.load_study(path)).motions[0].warnings
    assert any("the body is enclosed by the open part 'hall'" in line for line in said)


def test_copies_between_parts_are_counted_in_one_line_and_change_no_distance():
    seat = box_part("seat", [0, 0, 0], [1, 1, 1])
    cover = box_part("cover", [0, 0, 0], [1, 1, 1])
    sheet = without(box_part("sheet", [0, 0, 0], [1, 1, 1]), np.arange(4, 12))
    made = environment_of(seat, cover, sheet)
    (said,) = [line for line in made.warnings if "exactly on faces of other parts" in line]
    assert said.startswith(
        "16 faces lie exactly on faces of other parts, most of them (12) in seat and cover"
    )
    points = np.random.default_rng(1).uniform(-0.5, 1.5, (50, 3))
    alone = distances(environment_of(seat), points)[:, 0]
    np.testing.assert_allclose(
        distances(made, points)[:, :2], np.column_stack([alone, alone]), atol=1e-12
    )


def test_faces_of_solids_that_touch_are_no_copies():
    right = box([1, 0, 0], [2, 1, 1])
    touching = environment_of(box_part("left", [0, 0, 0], [1, 1, 1]), replace(right, name="right"))
    assert touching.warnings == ()


def test_many_parts_with_copies_are_told_in_one_line_for_each_kind():
    parts = []
    for k in range(60):
        one = box_part(f"bolt_{k}", [2 * k, 0, 0], [2 * k + 1, 1, 1])
        parts.append(
            RawPart(one.name, one.vertices, np.vstack([one.faces, one.faces[: 1 + k % 5]]))
        )
        parts.append(replace(one, name=f"copy_{k}"))
    made = environment_of(*parts)
    assert len(made.warnings) == 2
    assert made.warnings[0] == (
        "parts bolt_4, bolt_9, bolt_14 and 57 more: 180 duplicate faces in all left out "
        "(exactly on others); nothing that is found depends on it"
    )
    assert made.warnings[1].startswith(
        "720 faces lie exactly on faces of other parts, most of them (12) in"
    )


def test_a_solid_part_that_cannot_be_wound_alike_is_refused_with_the_reason():
    vertices = np.vstack([box_part("b", LOW, HIGH).vertices, [[0, 0, 4.0]]])
    _, faults = build_environment("a", [without(box_part("b", LOW, HIGH), [0])], solid=[True])
    assert "3 of its edges are open" in faults[0][1]
    wall = RawPart("walled", vertices[:8], np.vstack([BOX_FACES, [[0, 3, 7], [0, 7, 4]]]))
    _, faults = build_environment("a", [wall], solid=[True])
    assert "cannot be solid" in faults[0][1]


def test_a_mesh_with_an_open_solid_is_refused_by_name(tmp_path):
    path = written(tmp_path / "a.obj", without(box_part("lid", LOW, HIGH), [0]))
    with pytest.raises(InputError, match="part 'lid' cannot be solid: 3 of its edges are open"):
        environment_from_mesh(path, up="z", forward="x", length="m", solid=True)


def test_a_sphere_with_half_of_its_faces_turned_round_at_random_is_the_sphere():
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=0.5)
    part = RawPart("ball", np.array(sphere.vertices), np.array(sphere.faces))
    rng = np.random.default_rng(0)
    mixed = turned(part, np.flatnonzero(rng.random(len(part.faces)) < 0.5))
    made, found = validate_part(mixed)
    assert found.closed and found.against > 500
    assert trimesh.Trimesh(made.vertices, made.faces, process=False).volume == pytest.approx(
        sphere.volume
    )
