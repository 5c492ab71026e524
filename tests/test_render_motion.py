"""`workbench render` of motions: films and strips of motion files, one over another, ghosts; and
cut-aways."""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

import workbench as wb
from tests.conftest import ROOT
from tests.one_arm_cab import write_cab
from tests.test_crash import drop  # noqa: F401
from workbench import InputError, UsageError
from workbench.cli import main
from workbench.draw.camera import standard_view
from workbench.draw.display_options import parse_display_options
from workbench.draw.films.motion_clips import (
    at_times,
    common_time_span,
    overlay,
    parse_times,
    with_motion,
)
from workbench.draw.marks.annotations import with_marks
from workbench.draw.render import render
from workbench.draw.scene import Scene
from workbench.draw.scene_builder import build_source
from workbench.draw.section_planes import apply_section, cut_away, parse_section_plane
from workbench.files.motions.tables import angle_table_text

SVG = "{http://www.w3.org/2000/svg}"
SMALL = ("--size", "64")


@pytest.fixture(scope="module")
def moves(tmp_path_factory):
    """The cab, and in its folder swing.csv (elbow 0 to 90 degrees from 0 to 1 s) and late.csv (0 to
    45 from 0.5 s)."""
    folder = tmp_path_factory.mktemp("moves")
    cab = write_cab(folder)
    body = wb.load_body(folder / "bodies/one_arm.yaml")
    for name, most, begin in (("swing", 90.0, 0.0), ("late", 45.0, 0.5), ("never", 45.0, 7.0)):
        poses = wb.join_poses([wb.pose(body, {"ELBOW": {"flexion": a}}) for a in (0.0, most)])
        timed = replace(poses, time=np.array([begin, begin + 1.0]))
        (folder / f"{name}.csv").write_text("".join(angle_table_text(body, timed)))
    return folder, cab


@pytest.fixture
def run(moves, tmp_path, monkeypatch, capsys):
    """A command line in the cab's folder: exit code, what is told, and the path of the file that is
    asked for."""
    monkeypatch.chdir(moves[0])

    def call(name, source, *arguments):
        code = main(["render", source, "-o", str(tmp_path / name), *arguments])
        return code, capsys.readouterr().err, tmp_path / name

    return call


ARM = "bodies/one_arm.yaml"
CAB = "studies/cab_study.yaml"


def test_a_motion_file_becomes_a_film_of_its_time_at_the_rate_and_speed_asked_for(run):
    for arguments, count in (
        ((), 11),
        (("--speed", "0.5"), 21),
        (("--start", "0", "--end", "2"), 11),
    ):
        code, _, path = run(
            "x.gif", ARM, "--motion", "swing.csv", "--fps", "10", *SMALL, *arguments
        )
        assert code == 0
        with Image.open(path) as film:
            assert film.n_frames == count


@pytest.mark.parametrize("ending", [".webp", ".mp4", ".glb"])
def test_a_motion_file_becomes_every_kind_of_film_and_a_moving_model(run, ending):
    if ending == ".mp4":
        pytest.importorskip("imageio_ffmpeg")
    rate = () if ending == ".glb" else ("--fps", "5", *SMALL)
    code, _, path = run(f"x{ending}", ARM, "--motion", "swing.csv", "--over", "late.csv", *rate)
    assert code == 0 and path.stat().st_size > 500
    if ending == ".glb":
        data = path.read_bytes()
        told = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
        names = {node["name"] for node in told["nodes"]}
        assert told["animations"] and "one_arm" in names and "one_arm (late.csv)" in names


def test_a_picture_of_a_motion_is_a_strip_of_four_moments_or_of_those_asked_for(run):
    for arguments, captions in (
        ((), ["0 ms", "333 ms", "667 ms", "1000 ms"]),
        (("--at", "0, 0.25s,750ms"), ["0 ms", "250 ms", "750 ms"]),
    ):
        code, _, path = run("x.svg", ARM, "--motion", "swing.csv", *SMALL, *arguments)
        root = ElementTree.parse(path).getroot()
        assert code == 0 and [text.text for text in root.findall(f"{SVG}text")] == captions


def test_at_a_moment_the_body_is_where_the_motion_has_it(moves):
    found = at_times(with_motion(str(moves[0] / ARM), str(moves[0] / "swing.csv")), (0.5,))
    body = found.persons[0].body
    want = wb.place(body, wb.pose(body, {"ELBOW": {"flexion": 45}})).centres
    assert found.scene.bodies[0].placed.centres == pytest.approx(
        want, abs=1e-9
    ) and found.names == ("500 ms",)


def test_a_strip_with_a_trail_shows_earlier_positions_pale(run):
    _, _, path = run(
        "x.svg", ARM, "--motion", "swing.csv", "--at", "0,0.5,1", "--trail", "2", "--size", "200"
    )
    panels = [e for e in ElementTree.parse(path).getroot() if e.tag == f"{SVG}svg"]
    assert [sum(e.get("class") == "ghost" for e in panel.iter()) for panel in panels] == [0, 1, 2]


def test_predicted_over_actual_has_two_colours_and_says_which_is_which(run):
    _, _, path = run(
        "x.svg",
        ARM,
        "--motion",
        "swing.csv",
        "--over",
        "late.csv",
        "--at",
        "0.6,1",
        "--size",
        "200",
    )
    root = ElementTree.parse(path).getroot()
    keys = [[t.text for t in e] for e in root.iter(f"{SVG}g") if e.get("class") == "key"]
    assert keys == [["swing.csv", "late.csv"]]
    strokes = {e.get("stroke") for e in root.iter(f"{SVG}path")}
    assert {"#423024", "#143a7a"} <= strokes  # warm and blue ink


def test_two_motions_are_shown_in_the_time_they_share(moves):
    arm = str(moves[0] / ARM)
    swing, late, never = (
        with_motion(arm, str(moves[0] / f"{name}.csv")) for name in ("swing", "late", "never")
    )
    over = overlay(swing, late, ("swing", "late"))
    assert common_time_span(over) == (0.5, 1.0)
    shown = at_times(over, (1.0,))
    bend = [
        wb.place(
            shown.persons[0].body, wb.pose(shown.persons[0].body, {"ELBOW": {"flexion": a}})
        ).centres
        for a in (90, 22.5)
    ]
    assert shown.scene.bodies[0].placed.centres == pytest.approx(bend[0], abs=1e-9)
    assert shown.scene.ghosts[0].placed.centres == pytest.approx(bend[1], abs=1e-9)
    with pytest.raises(InputError, match="no time in common: 0 to 1 s and 7 to 8 s"):
        overlay(swing, never, ("swing", "never"))
    with pytest.raises(UsageError, match=r"goes from 0.5 to 1 s, got 0.2"):
        at_times(over, (0.2,))


def test_somebody_in_a_study_moves_and_the_others_sit_as_in_the_case(moves, monkeypatch):
    monkeypatch.chdir(moves[0])
    still = build_source(CAB, case="forward")
    found = with_motion(CAB, "bert=swing.csv", case="forward").at(np.array([0.0, 1.0]))
    anna, bert = found.scene.bodies
    assert (
        anna.placed.centres == pytest.approx(still.scene.bodies[0].placed.centres)
        and len(bert.placed) == 2
    )
    assert with_motion(CAB, "swing.csv").persons[0].poses.time.tolist() == [0.0, 1.0]
    with pytest.raises(UsageError, match="nobody is called 'bart'; did you mean 'bert'"):
        with_motion(CAB, "bart=swing.csv")


def test_marks_move_along_with_what_they_are_about(moves, monkeypatch):
    monkeypatch.chdir(moves[0])
    found = with_marks(with_motion(ARM, "swing.csv"), ("segments",))
    texts = []
    for at in ("0", "1"):
        out = moves[0] / f"marks{at}.svg"
        render(found, parse_display_options(out, at=at, size="200", view="left"), out)
        labels = [
            e for e in ElementTree.parse(out).getroot().iter(f"{SVG}text") if e.text == "HAND"
        ]
        texts.append((labels[0].get("x"), labels[0].get("y")))
    assert texts[0] != texts[1]


def test_one_posture_lies_over_another_body_s(run):
    code, _, path = run("x.png", ARM, "--pose", "bent", "--over", ARM, *SMALL)
    with Image.open(path) as image:
        assert code == 0 and image.size == (64, 64)


def test_a_crash_study_is_drawn_as_a_strip_and_its_result_over_what_it_is_compared_with(
    drop,  # noqa: F811
    tmp_path,
    capsys,
):
    motion = "{motion: {file: drop.csv, move: [300, 0, 0]}}"
    actual = f"  - {{name: actual, people: {{occupant: {motion}}}}}\n"
    drop.write_text(drop.read_text().replace("signals:", actual + "signals:"))
    found = build_source(str(drop))
    assert (
        found.moving
        and len(found.scene.ghosts) == 1
        and found.scene.key == (("the fall", "warm"), ("actual", "blue"))
    )
    shown = at_times(found, (0.07,))
    apart = shown.scene.ghosts[0].placed.centres - shown.scene.bodies[0].placed.centres
    assert apart == pytest.approx(np.broadcast_to([0.3, 0.0, 0.0], apart.shape), abs=1e-9)
    alone = build_source(str(drop), case="actual")
    assert not alone.scene.ghosts
    with pytest.raises(UsageError, match="has no case 'x'; valid: the fall, actual"):
        build_source(str(drop), case="x")


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["cut=middle"], 2, "no side or axis 'middle'; valid: front"),
        (["cut=left=here"], 2, "a place such as left=0.3 [m] or left=300mm"),
        (["cut=left=3 furlongs"], 2, "units: mm, cm, m, in, ft"),
        (["cut=left=9"], 2, "this plane misses it"),
        (
            ["cut=x=0.1", "view=left"],
            2,
            "looks along this plane; say which side goes: front or back",
        ),
        (["motion=none.csv"], 3, "none.csv: no such motion file"),
        (["motion=x.avi"], 3, "no such motion file"),
        (["motion=swing.csv", "case=down,forward"], 2, "sit as in one case"),
        (["at=0"], 2, "nothing moves in One arm in a cab"),
        (["motion=swing.csv", "at=soon"], 2, "times with commas between"),
        (["motion=swing.csv", "at=0,9"], 2, "from 0 to 1 s, got 9"),
        (["motion=swing.csv", "start=3", "end=1"], 2, "start 3 s must be before end 1 s"),
        (["start=1"], 2, "are about a motion file"),
        (["trail=-1"], 2, "0 to 50 earlier positions"),
        (["trail=2", "display=scanline"], 2, "shows no pale bodies"),
        (["over=late.csv", "display=disks", "style=id"], 2, "shows no pale bodies"),
        (["over=cab"], 2, "there is no body in cab"),
        (["motion=swing.csv", "over=never.csv"], 3, "no time in common"),
    ],
)
def test_what_makes_no_sense_is_one_sentence_and_no_file(run, arguments, code, message):
    flags = [
        part
        for argument in arguments
        for part in (f"--{argument.split('=', 1)[0]}", argument.split("=", 1)[1])
    ]
    got, told, path = run("x.png", CAB, *SMALL, *flags)
    assert got == code and message in told and told.count("\n") == 1 and not path.exists()


@pytest.mark.parametrize(
    ("name", "source", "arguments", "message"),
    [
        (
            "x.gif",
            ARM,
            ["--motion", "swing.csv", "--at", "0"],
            "shows the whole motion; --start and --end",
        ),
        ("x.stl", ARM, ["--motion", "swing.csv"], "say at which moment of the motion by --at"),
        ("x.stl", ARM, ["--over", ARM], "holds one pose of a body, nothing pale"),
        ("x.glb", CAB, ["--cut", "left"], "leave out --cut"),
        ("x.png", ARM, ["--cut", "left"], "it opens an environment, and there is none in one_arm"),
        ("x.png", ARM, ["--motion", "swing.csv", "--pose", "bent"], "leave out --pose or --motion"),
        (
            "x.png",
            "environments/cab",
            ["--motion", "swing.csv"],
            "is an environment: --motion is for bodies",
        ),
    ],
)
def test_what_does_not_fit_the_source_or_the_file_is_refused(run, name, source, arguments, message):
    code, told, path = run(name, source, *arguments)
    assert code == 2 and message in told and not path.exists()


def test_a_solid_of_one_moment_of_a_motion(run):
    code, _, path = run("x.stl", ARM, "--motion", "swing.csv", "--at", "0.5")
    assert code == 0 and path.stat().st_size > 1000


def test_a_cut_takes_the_side_that_is_named_or_the_viewer_s(moves):
    scene = build_source("trainer").scene
    front, back = (
        standard_view(name, scene.bounds, width=64, height=64) for name in ("front", "back")
    )
    for text, camera, kept in (
        ("left=0.1", front, (None, 0.1)),
        ("right=100mm", front, (0.1, None)),
        ("x=0.2", front, (None, 0.2)),
        ("x=0.2", back, (0.2, None)),
    ):
        cut = parse_section_plane(text)
        axis = 0 if text[0] == "x" else 1
        left = apply_section(scene, camera, cut).vertices[:, axis]
        for end, bound in zip((left.min(), left.max()), kept, strict=True):
            assert bound is None or end == pytest.approx(bound, abs=1e-9)


def test_a_cut_box_is_closed_by_a_face_of_its_size(moves):
    cab = wb.load_environment(moves[0] / "environments/cab")
    part = int(np.flatnonzero(cab.solid & ~cab.hidden)[0])
    rows = cab.polygons(part)
    corners = cab.vertices[
        cab.triangles[cab.triangle_start[rows.start] : cab.triangle_start[rows.stop]]
    ]
    middle = corners.reshape(-1, 3).min(axis=0) * 0.5 + corners.reshape(-1, 3).max(axis=0) * 0.5
    open_ = cut_away(cab, middle, [0.0, 0.0, 1.0])
    rows = open_.polygons(part)
    cap = (
        np.flatnonzero(np.isclose(open_.offset[rows], middle[2]) & (open_.normal[rows, 2] > 0.999))
        + rows.start
    )
    first, last = open_.triangle_start[[cap[-1], cap[-1] + 1]]
    a, b, c = np.moveaxis(open_.vertices[open_.triangles[first:last]], 1, 0)
    area = np.cross(b - a, c - a)[:, 2].sum() / 2.0
    size = np.ptp(corners.reshape(-1, 3), axis=0)
    assert area == pytest.approx(size[0] * size[1], rel=1e-9)  # upward, and as large as the box


def test_every_cut_of_the_trainer_keeps_whole_bodies_and_finds_faces():
    scene = build_source("trainer_clearance").scene
    camera = standard_view("corner", scene.bounds, width=64, height=64)
    count = len(scene.environment.normal)
    for side in ("left", "right", "front", "back", "top", "bottom"):
        environment = apply_section(scene, camera, parse_section_plane(side))
        assert len(environment.normal) > count  # each of them goes through solids
        assert np.all(np.diff(environment.polygon_part) >= 0)
        assert isinstance(replace(scene, environment=environment), Scene)


def test_instants_may_say_their_unit():
    assert parse_times("0, 50ms,0.1 s") == (0.0, 0.05, 0.1)


@pytest.mark.nightly
def test_a_real_ctrl_c_leaves_a_film_that_plays(tmp_path):
    out = tmp_path / "x.gif"
    command = [
        sys.executable,
        "-m",
        "workbench",
        "render",
        "bubbleman",
        "-o",
        str(out),
        "--size",
        "600",
        "--fps",
        "50",
    ]
    film = subprocess.Popen(
        command, env=os.environ | {"PYTHONPATH": str(ROOT)}, stderr=subprocess.PIPE
    )
    partial = tmp_path / ".x.gif.workbench-partial"
    for _ in range(600):
        if partial.exists():
            break
        time.sleep(0.1)
    time.sleep(1.0)
    film.send_signal(signal.SIGINT)
    told = film.communicate(timeout=60)[1].decode()
    assert film.returncode == 130 and "stopped after" in told and "Traceback" not in told
    shown = Image.open(io.BytesIO(out.read_bytes()))
    assert f"stopped after {shown.n_frames} of" in told
