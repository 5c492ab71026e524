"""Turnable pictures before any browser: what is packed, how large it is, what the script may do."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import os
import re
import subprocess
import zlib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import ROOT
from tests.web_page import node
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.draw.web.case_view import compared_view
from workbench.draw.web.packing import FINE, TENTH, Packing
from workbench.draw.web.snippet import PAGE, WIDGET, policy, script, standalone, style
from workbench.draw.web.views import WebBody, WebView, body_view, scene_view
from workbench.model.surroundings import Move, displaced

WEB = ROOT / "workbench" / "draw" / "web"
MOST_BYTES = 25_000
MOST_LINES = 250


@pytest.fixture(scope="module")
def arm_view(one_arm, box_cab):
    """The one arm in the cab of three boxes."""
    placed = wb.place(one_arm, wb.pose(one_arm, {"ELBOW": {"flexion": 90}}))
    return WebView("an arm", (body_view(placed, "anna", "warm", failing=(1,)),), box_cab)


def unpacked(packing):
    """Header and raw arrays of a block, by plain Python."""
    whole = zlib.decompress(packing.block(), -15)
    length = int.from_bytes(whole[:4], "little")
    header = json.loads(whole[4 : 4 + length])
    at = 4 + length
    arrays = []
    for entry in header["arrays"]:
        kind = np.dtype("<" + entry["kind"])
        size = entry["count"] * kind.itemsize
        planes = np.frombuffer(whole[at : at + size], np.uint8).reshape(kind.itemsize, -1)
        values = np.ascontiguousarray(planes.T).view(kind).ravel().copy()
        at += size
        for k in range(entry["stride"]):
            values[k :: entry["stride"]] = np.cumsum(values[k :: entry["stride"]], dtype=kind)
        if "step" in entry:
            columns = values.reshape(-1, len(entry["origin"])) * entry["step"]
            values = columns + np.array(entry["origin"])
        arrays.append(values)
    assert at == len(whole)
    return header, arrays


def test_two_states_hold_once_what_is_alike_and_name_what_is_not(arm_view, box_cab):
    moved = displaced(box_cab, [Move(("wall",), (), (0.0, 0.1, 0.0))])
    after = replace(arm_view, environment=moved)
    view = compared_view(arm_view, after, names=("old", "new"), title="a wall moved")
    packing = Packing()
    packing.add(view)
    header, arrays = unpacked(packing)
    shown = header["views"][0]
    parts = {part["name"]: part.get("state") for part in shown["place"]["parts"]}
    assert parts == {"floor": None, "wall, new": 1, "post": None, "wall, old": 0}
    assert [body["name"] for body in shown["bodies"]] == ["anna"]
    assert "state" not in shown["bodies"][0]
    assert shown["states"] == ["old", "new"]
    corners = arrays[shown["place"]["vertices"]]
    part = arrays[shown["place"]["part"]].ravel()
    names = list(parts)
    new, old = (corners[part == names.index(name)] for name in ("wall, new", "wall, old"))
    assert new - old == pytest.approx(np.tile([0.0, 0.1, 0.0], (len(old), 1)), abs=TENTH)
    triangles = arrays[shown["place"]["triangles"]].astype(int)
    assert len(triangles) == 4 * len(box_cab.triangles)
    assert (part[triangles].reshape(-1, 3) == part[triangles].reshape(-1, 3)[:, :1]).all()


def test_two_motions_of_different_times_are_not_one_picture(arm_view):
    later = replace(arm_view, times=(0.0, 0.1))
    with pytest.raises(wb.InputError, match="at the same times"):
        compared_view(arm_view, later, names=("old", "new"), title="an arm")


def test_what_is_packed_comes_out_to_half_a_step(arm_view, box_cab):
    packing = Packing()
    assert packing.add(arm_view) == 0
    header, arrays = unpacked(packing)
    body = header["views"][0]["bodies"][0]
    given_body = arm_view.bodies[0]
    assert arrays[body["centres"]] == pytest.approx(given_body.centres[0], abs=TENTH / 2)
    assert arrays[body["radius"]].ravel() == pytest.approx(given_body.radius, abs=FINE / 2)
    place = header["views"][0]["place"]
    corners = arrays[place["vertices"]][arrays[place["triangles"]].astype(int)]
    expected = box_cab.vertices[box_cab.triangles].reshape(-1, 3)
    assert corners == pytest.approx(expected, abs=TENTH / 2)
    assert [part["name"] for part in place["parts"]] == list(box_cab.parts)
    assert len(arrays[place["edges"]]) == 2 * 12 * 3  # twelve edges of each of three boxes


@given(
    st.lists(
        st.tuples(*[st.floats(-900, 900, allow_subnormal=False)] * 3), min_size=1, max_size=30
    ),
    st.integers(1, 4),
)
def test_any_motion_comes_out_to_half_a_step(points, frames):
    still = np.array(points)
    centres = np.stack([still + 0.01 * k for k in range(frames)])
    body = WebBody(
        "b",
        (1, 2, 3),
        np.full(len(still), 0.1),
        centres,
        np.zeros(len(still), dtype=np.int64),
        ("all",),
        ("",) * len(still),
    )
    packing = Packing()
    packing.add(WebView("v", (body,), times=tuple(range(frames))))
    header, arrays = unpacked(packing)
    found = arrays[header["views"][0]["bodies"][0]["centres"]]
    assert found.reshape(centres.shape) == pytest.approx(centres, abs=TENTH / 2 + 1e-9)


def test_the_same_scene_gives_the_same_bytes_and_shared_arrays_are_kept_once(arm_view):
    assert standalone(arm_view) == standalone(arm_view)
    one, two = Packing(), Packing()
    one.add(arm_view)
    two.add(arm_view)
    two.add(replace(arm_view, title="the same again"))
    assert len(two.arrays) == len(one.arrays)
    assert len(two.block()) < 1.3 * len(one.block())


def test_hidden_parts_are_not_in_the_page(box_cab, arm_view):
    hidden = replace(box_cab, hidden=np.array([False, True, False]))
    packing = Packing()
    packing.add(replace(arm_view, environment=hidden))
    place = unpacked(packing)[0]["views"][0]["place"]
    assert [part["name"] for part in place["parts"]] == [box_cab.parts[0], box_cab.parts[2]]


def test_a_coordinate_that_is_no_number_is_refused(arm_view):
    body = arm_view.bodies[0]
    bad = replace(body, centres=np.full_like(body.centres, np.nan))
    with pytest.raises(wb.InputError, match="coordinates must be finite"):
        Packing().add(WebView("v", (bad,)))


def test_a_scene_with_marks_and_ghosts_becomes_a_view(one_arm, box_cab):
    placed = wb.place(one_arm, wb.pose(one_arm, {}))
    marks = (
        Mark((0, 0, 0), "12.0 mm", "clearance", (0.1, 0, 0)),
        Mark((0, 0, 1), "1", "contact"),
    )
    scene = Scene((SceneBody(placed),), box_cab, marks, "t", ghosts=(SceneBody(placed, 0, "grey"),))
    view = scene_view(scene, ["anna"])
    assert [(body.name, body.ghost) for body in view.bodies] == [("anna", False), ("one_arm", True)]
    assert [(mark.to, mark.failing) for mark in view.marks] == [((0.1, 0, 0), False), (None, True)]


def test_spheres_outside_the_logical_window_are_left_out(one_arm):
    window = ["LOWER", "HAND"]
    placed = wb.place(one_arm, wb.pose(one_arm, {}), window=window, reference="LOWER")
    inside = np.isin([one_arm.segments[n] for n in one_arm.sphere_segment], window)
    last = len(inside) - 1
    body = body_view(placed, "anna", "warm", failing=(0, last))
    assert len(body.radius) == inside.sum()
    assert body.failing == (int(inside.sum()) - 1,)


def test_the_viewer_is_small():
    packed = gzip.compress((script() + style()).encode(), 9)
    assert len(packed) < MOST_BYTES
    for path in WEB.glob("*.js"):
        assert len(path.read_text().splitlines()) <= MOST_LINES, path.name


@pytest.mark.parametrize("modules", [PAGE, WIDGET], ids=["page", "widget"])
def test_every_module_is_joined_once_after_what_it_imports(modules):
    assert {path.stem for path in WEB.glob("*.js")} == {*PAGE, *WIDGET}
    for k, name in enumerate(modules):
        text = (WEB / f"{name}.js").read_text()
        assert set(re.findall(r'from "\./(\w+)\.js"', text)) <= set(modules[:k])
    joined = script(modules)
    declared = re.findall(r"^(?:async )?(?:function|class|const|let) (\w+)", joined, re.M)
    assert len(set(declared)) == len(declared)
    assert "import " not in joined
    assert re.findall(r"export \w+", joined) == ["export default"] * (modules is WIDGET)


def test_the_policy_names_the_script_by_its_hash_and_lets_nothing_else_in(arm_view):
    page = standalone(arm_view)
    (text,) = re.findall(r'<script type="module">(.*?)</script>', page, re.S)
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy()
    assert policy().startswith("default-src 'none'; ") and "media-src" not in policy()
    assert "media-src 'self' file:" in policy(media=True)
    assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(", script())


def test_a_name_cannot_leave_its_place_in_the_page(arm_view):
    title = '</script><script>alert(1)</script>"&<b>'
    page = standalone(replace(arm_view, title=title), caption=title)
    assert page.count("<script") == 2 and "<b>" not in page


def test_the_script_is_valid_and_its_arithmetic_is_right(tmp_path, arm_view):
    """Node checks the joined script, and runs the tests of camera, picking and unpacking."""
    joined = tmp_path / "joined.mjs"
    joined.write_text(script())
    packing = Packing()
    packing.add(arm_view)
    block = tmp_path / "block.bin"
    block.write_bytes(packing.block())
    numbers = tmp_path / "numbers.json"
    env = os.environ | {
        "WEB_MODULES": WEB.as_uri(),
        "WEB_BLOCK": str(block),
        "WEB_NUMBERS": str(numbers),
    }
    for arguments in (["--check", joined], ["--test", ROOT / "tests" / "web_modules.test.mjs"]):
        done = subprocess.run([node(), *arguments], env=env, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    header, arrays = unpacked(packing)
    found = json.loads(numbers.read_text())
    view = header["views"][0]
    for name in ("centres", "radius"):
        expected = arrays[view["bodies"][0][name]].ravel()
        assert found[name] == pytest.approx(expected, abs=1e-6)
    for name in ("vertices", "triangles", "edges", "part"):
        assert found[name] == pytest.approx(arrays[view["place"][name]].ravel(), abs=1e-6)
