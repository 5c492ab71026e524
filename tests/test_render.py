"""`workbench render`: every display for every body and environment, every file, and what does not
go together."""

from __future__ import annotations

import io
import json
from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from PIL import Image

import workbench as wb
from tests.one_arm_cab import write_cab
from workbench import InputError, MissingPartError, UsageError
from workbench.cli import main
from workbench.draw import logical_window
from workbench.draw.display_options import DISPLAYS, ENDINGS, parse_display_options
from workbench.draw.marks.annotations import MARKS, with_marks
from workbench.draw.render import render
from workbench.draw.scene_builder import build_source
from workbench.files.catalogue import find, names

SMALL = "64x48"
# a study of a whole population has nobody in particular to draw
CASES = [
    name for name in names("studies") if "population: {" not in find("studies", name).read_text()
]
SOURCES = [*names("bodies"), *names("environments", "environment.yaml"), "trainer_clearance"]
LIVE = [
    (name, style)
    for name, display in DISPLAYS.items()
    for style in display.styles
    if name != "pyvista" and display.kind != "chart"  # see test_sight_pictures
]
DRAWN = [
    *((source, display, style) for source in SOURCES for display, style in LIVE),
    *((source, "disks", "flat") for source in CASES if source not in SOURCES),
    ("trainer_reach", "outline", "veiled"),
]
"""Every body and environment and the first study in every display, the other studies in one."""


@pytest.fixture(scope="module")
def cab(tmp_path_factory):
    """The study of the small cab."""
    return write_cab(tmp_path_factory.mktemp("cab"))


def made(tmp_path, source, name, **look):
    """The bytes of a file that is rendered from a source."""
    out = tmp_path / name
    render(
        source if not isinstance(source, str) else build_source(source),
        parse_display_options(out, **look),
        out,
    )
    return out.read_bytes()


@cache
def catalogued(source):
    """What a source of the catalogue shows, read, seated and reached for once for all displays."""
    return build_source(source)


@pytest.mark.parametrize(("source", "display", "style"), DRAWN)
def test_every_display_draws_everything_in_the_catalogue(tmp_path, source, display, style):
    if source in names("environments", "environment.yaml") and (
        display == "scanline" or style in ("id", "depth")
    ):
        with pytest.raises(UsageError, match="shows bodies only"):
            made(tmp_path, catalogued(source), "x.png", display=display, style=style, size=SMALL)
        return
    recorded = source in CASES and catalogued(source).moving  # a strip of four moments
    width, height = (4 * 72 - 8, 48 + 26) if recorded else (64, 48)
    if DISPLAYS[display].kind == "raster":
        image = Image.open(
            io.BytesIO(
                made(
                    tmp_path, catalogued(source), "x.png", display=display, style=style, size=SMALL
                )
            )
        )
        assert image.size == (width, height) and len(set(image.convert("RGB").tobytes())) > 8
    else:
        root = ElementTree.fromstring(
            made(tmp_path, catalogued(source), "x.svg", display=display, style=style, size=SMALL)
        )
        assert root.get("viewBox") == f"0 0 {width} {height}" and len(list(root.iter())) > 8


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_body_becomes_every_kind_of_file(cab, tmp_path, ending, monkeypatch):
    if ending == ".mp4":
        pytest.importorskip("imageio_ffmpeg")
    arm = str(cab.parents[1] / "bodies/one_arm.yaml")
    look = {"size": SMALL} if ENDINGS[ending].display else {}
    look |= {"fps": 2.0} if ENDINGS[ending].holds == "film" else {}
    first = made(tmp_path, arm, f"one{ending}", **look)
    assert first and first == made(tmp_path, arm, f"two{ending}", **look)
    assert sorted(p.name for p in tmp_path.iterdir()) == [f"one{ending}", f"two{ending}"]


def test_several_poses_stand_side_by_side_in_a_picture_and_move_in_a_model_and_a_film(
    cab, tmp_path
):
    arm = build_source(str(cab.parents[1] / "bodies/one_arm.yaml"), poses="hanging,bent")
    strip = Image.open(io.BytesIO(made(tmp_path, arm, "x.png", size="60x40")))
    assert strip.size == (128, 66)
    root = ElementTree.fromstring(made(tmp_path, arm, "x.svg", size="60x40"))
    assert [text.text for text in root.findall("{http://www.w3.org/2000/svg}text")] == [
        "hanging",
        "bent",
    ]
    assert b'"animations"' in made(tmp_path, arm, "x.glb")
    film = Image.open(io.BytesIO(made(tmp_path, arm, "x.gif", size="60x40", fps=5.0)))
    assert film.n_frames == 6
    slow = Image.open(io.BytesIO(made(tmp_path, arm, "slow.gif", size="60x40", fps=5.0, speed=0.5)))
    assert slow.n_frames == 11


def test_a_film_of_what_does_not_move_goes_round_it(cab, tmp_path):
    arm = build_source(str(cab.parents[1] / "bodies/one_arm.yaml"), poses="bent")
    film = Image.open(io.BytesIO(made(tmp_path, arm, "x.gif", size="160", fps=2.0, view="front")))
    frames = []
    for k in range(film.n_frames):
        film.seek(k)
        frames.append(np.asarray(film.convert("L"))[:115] < 250)
    assert len(frames) == 12  # from behind the silhouette is the mirrored one
    assert (
        (frames[0] ^ frames[6][:, ::-1]).sum()
        < 0.15 * frames[0].sum()
        < (frames[0] ^ frames[3]).sum()
    )


def test_a_study_is_drawn_in_one_case_or_several_and_from_its_people_s_eyes(cab, tmp_path):
    study = wb.load_study(cab)
    both = build_source(str(cab), case=",".join(case.name for case in study.cases[:2]))
    assert Image.open(io.BytesIO(made(tmp_path, both, "x.png", size="50"))).size == (108, 76)
    with pytest.raises(UsageError, match="2 cases without times"):
        made(tmp_path, both, "x.gif")
    with pytest.raises(UsageError, match="one pose; got"):
        made(tmp_path, both, "x.stl")
    seen = [
        made(tmp_path, "trainer_clearance", "x.png", size=SMALL, view=view)
        for view in ("eye", "eye:instructor")
    ]
    assert seen[0] != seen[1]
    with pytest.raises(UsageError, match="nobody is called 'pylot'; did you mean 'pilot'"):
        made(tmp_path, "trainer_clearance", "x.png", size=SMALL, view="eye:pylot")
    with pytest.raises(UsageError, match="no body here"):
        made(tmp_path, "trainer", "x.png", size=SMALL, view="eye")


def test_a_perspective_picture_differs_and_has_no_scale_bar(tmp_path):
    flat, deep = (
        made(tmp_path, "bubbleman", "x.svg", size="200", angle=angle).decode()
        for angle in (None, 40.0)
    )
    assert 'class="scale"' in flat and 'class="scale"' not in deep


def test_marks_of_every_kind_can_be_asked_for():
    source = with_marks(build_source("trainer_clearance"), MARKS)
    assert {"axis_x", "clearance", "allowed", "reach", "segment"} <= {
        mark.kind for mark in source.scene.marks
    }
    assert not with_marks(
        build_source("bubbleman"), ("stops", "contacts", "controls", "clearances")
    ).scene.marks
    with pytest.raises(UsageError, match="no marks 'contcts'; did you mean 'contacts'"):
        with_marks(source, ("contcts",))


def test_a_result_is_drawn_with_its_findings_and_refused_when_its_study_has_changed(
    cab, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(cab.parents[1])
    strict = cab.with_name("strict.yaml")
    strict.write_text(
        cab.read_text()
        .replace("study: cab_study", "study: strict")
        .replace("at_least: 100", "at_least: 300")
    )
    assert main(["run", "strict", "--out", str(tmp_path / "result")]) == 1
    assert (
        main(["render", str(tmp_path / "result"), "-o", str(tmp_path / "x.png"), "--size", SMALL])
        == 0
    )
    assert "1: " in capsys.readouterr().err
    source = build_source(str(tmp_path / "result" / "result.json"))
    assert "1" in {m.label for m in source.scene.marks if m.kind == "contact"}
    strict.write_text(strict.read_text() + "\n# changed\n")
    with pytest.raises(InputError, match=r"strict.yaml is not as it was .*run the study again"):
        build_source(str(tmp_path / "result"))
    (tmp_path / "result" / "result.json").write_text(json.dumps({"study": "x"}))
    with pytest.raises(InputError, match="is no result of this version"):
        build_source(str(tmp_path / "result"))


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["bubbleman", "-o", "x.jpg"], 2, "valid: .png, .svg, .gif, .webp, .mp4, .glb, .stl, .3mf"),
        (
            ["bubbleman", "-o", "x.png", "--display", "outline"],
            2,
            "the display outline makes .svg, not .png",
        ),
        (["bubbleman", "-o", "x.svg", "--display", "disks"], 2, "for .svg take outline, circles"),
        (["bubbleman", "-o", "x.gif", "--display", "circles"], 2, "for .gif take disks"),
        (["bubbleman", "-o", "x.png", "--style", "veiled"], 2, "disks has no style 'veiled'"),
        (
            ["bubbleman", "-o", "x.glb", "--view", "left", "--size", "9"],
            2,
            "leave out --view and --size",
        ),
        (["bubbleman", "-o", "x.png", "--fps", "9"], 2, "is no film"),
        (["bubbleman", "-o", "x.gif", "--fps", "60"], 2, "0.1 to 50 frames a second, got 60"),
        (["bubbleman", "-o", "x.gif", "--speed", "0"], 2, "a speed above 0 is needed"),
        (["bubbleman", "-o", "x.gif", "--view", "eye"], 2, "nothing moves here"),
        (["bubbleman", "-o", "x.png", "--angle", "200"], 2, "0 (a parallel view) to 170 degrees"),
        (["bubbleman", "-o", "x.png", "--size", "99999x16"], 2, "16 to 8192 pixels each way"),
        (
            ["bubbleman", "-o", "x.png", "--pose", "standing,,seated"],
            2,
            "names with commas between",
        ),
        (
            ["bubbleman", "-o", "x.png", "--case", "cruise"],
            2,
            "is a body: --case is for studies, --pose for bodies",
        ),
        (
            ["trainer", "-o", "x.png", "--pose", "standing"],
            2,
            "is an environment: --pose is for bodies",
        ),
        (["trainer", "-o", "x.stl"], 2, "there is none in trainer"),
        (["trainer_clearance", "-o", "x.png", "--case", "crusing"], 2, "has no case 'crusing'"),
        (
            ["bubbleman", "-o", "x.png", "--marks", "everything"],
            2,
            "no marks 'everything'; valid: axes",
        ),
        (["bubbleman", "-o", "x.png", "--pose", "std"], 3, "no posture 'std'"),
        (
            ["trainer_accommodation", "-o", "x.png"],
            3,
            "is about many people and has no case to draw",
        ),
    ],
)
def test_what_does_not_go_together_is_one_clear_message_and_no_file(
    capsys, tmp_path, monkeypatch, arguments, code, message
):
    monkeypatch.chdir(tmp_path)
    assert main(["render", *arguments]) == code
    told = capsys.readouterr()
    assert message in told.err and not told.out and not list(tmp_path.iterdir())
    said = told.err.removeprefix(f"reading {arguments[0]}\n")  # where that takes a while
    assert "Traceback" not in said and said.count("\n") == 1


def test_ctrl_c_keeps_the_finished_frames_and_says_so(capsys, cab, tmp_path, monkeypatch):
    drawn = []

    def three_then_stop(scene, camera, look):
        drawn.append(Image.new("RGB", (64, 64), (0, 60 * len(drawn), 0)))
        if len(drawn) > 3:
            raise KeyboardInterrupt
        return drawn[-1]

    monkeypatch.setattr("workbench.draw.render.picture", three_then_stop)
    out = tmp_path / "x.gif"
    assert (
        main(["render", str(cab.parents[1] / "bodies/one_arm.yaml"), "-o", str(out), "--fps", "2"])
        == 130
    )
    assert "stopped after 3 of 12 frames" in capsys.readouterr().err
    with Image.open(out) as film:
        assert film.n_frames == 3


def test_where_vtk_cannot_draw_the_message_names_the_packages_and_the_exit_code_is_4(
    capsys, tmp_path, monkeypatch
):
    fault = logical_window.drawing_fault("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
    assert "signal 11" in fault and "apt install libegl1 libgl1" in fault
    assert "pip install pyvista" in logical_window.drawing_fault(
        "raise ModuleNotFoundError(\"No module named 'pyvista'\")"
    )
    monkeypatch.setattr(logical_window, "drawing_fault", lambda: fault)
    for flag in ("--display", "--style"):
        assert main(["render", "bubbleman", "-o", str(tmp_path / "x.png"), flag, "pyvista"]) == 4
    assert "apt install" in capsys.readouterr().err and not list(tmp_path.iterdir())
    with pytest.raises(MissingPartError):
        logical_window.to_pyvista(build_source("bubbleman").scene)


@pytest.mark.nightly
def test_pyvista_shows_the_scene_where_disks_show_it(tmp_path):
    pytest.importorskip("pyvista")
    if logical_window.drawing_fault():
        pytest.skip(logical_window.drawing_fault())
    for angle in (None, 40.0):
        pictures = [
            np.asarray(
                Image.open(
                    io.BytesIO(
                        made(
                            tmp_path, "bubbleman", "x.png", size="200", display=display, angle=angle
                        )
                    )
                )
            ).min(axis=2)
            < 250
            for display in ("disks", "pyvista")
        ]
        assert (pictures[0] ^ pictures[1])[:170].sum() < 0.06 * pictures[0].sum()
    scene = build_source("trainer_clearance").scene
    names_shown = set(logical_window.to_pyvista(scene, off_screen=True).actors)
    assert {"canopy", "bubbleman 0", "bubbleman 1"} <= names_shown


def test_a_solid_file_holds_each_person_by_name(cab, tmp_path):
    data = made(tmp_path, str(cab), "x.3mf")
    scene = trimesh.load(io.BytesIO(data), file_type="3mf")
    assert len(scene.geometry) == len(wb.load_study(cab).roles)
