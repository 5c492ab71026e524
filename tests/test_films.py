"""Films, motions between poses, ghosts and strips."""

from __future__ import annotations

import io
import subprocess
import sys
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

import workbench as wb
from tests.conftest import ROOT
from tests.test_draw import SVG, crowd, front, spheres_body
from workbench import InputError, MissingPartError, Placed, UsageError
from workbench.draw.disks import disks, ghost_strengths
from workbench.draw.display_options import parse_display_options
from workbench.draw.films.film import (
    every_pose,
    film_frames,
    frame_times,
    scene_at,
    stamp_text,
    write_film,
)
from workbench.draw.films.strip import strip_image, strip_svg
from workbench.draw.lines.circles import circles
from workbench.draw.render import camera_for_all_poses
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.scene_builder import build_source
from workbench.draw.visibility import cut_depth, projected_disks
from workbench.model.joint_angles import poses_at


@pytest.fixture(scope="module")
def swing(one_arm):
    """The elbow from 0 to 90 degrees in one second, the base 1 m forward meanwhile."""
    poses = [wb.pose(one_arm, {"ELBOW": {"flexion": a}}, position=(a / 90, 0, 0)) for a in (0, 90)]
    joined = wb.join_poses(poses)
    return (
        joined
        if joined.time is not None
        else replace(joined, time=np.arange(len(joined), dtype=np.float64))
    )


def moving(one_arm, swing, count=5):
    times = np.linspace(0, 1, count)
    return Scene((SceneBody(wb.place(one_arm, poses_at(swing, times))),)), times


def test_half_way_in_time_is_half_way_in_angle_and_place(one_arm, swing):
    half = poses_at(swing, np.array([0.5]))
    want = wb.pose(one_arm, {"ELBOW": {"flexion": 45}}, position=(0.5, 0, 0))
    assert half.rotations == pytest.approx(
        want.rotations
    ) and half.world_from_reference == pytest.approx(want.world_from_reference)


def test_at_its_own_times_a_motion_is_itself_and_outside_them_it_stands_still(swing):
    again = poses_at(swing, np.array([-3.0, 0.0, 1.0, 7.0]))
    assert again.rotations == pytest.approx(swing.rotations[[0, 0, 1, 1]])
    with pytest.raises(UsageError, match="times that rise"):
        poses_at(replace(swing, time=None), np.zeros(1))


def test_a_film_of_one_second_at_25_frames_has_26_and_ten_times_slower_has_251():
    assert len(frame_times(0.0, 1.0, fps=25)) == 26
    assert len(frame_times(0.0, 1.0, fps=25, speed=0.1)) == 251
    assert frame_times(2.0, 3.0, fps=10, speed=2.0).tolist() == pytest.approx(
        [2.0, 2.2, 2.4, 2.6, 2.8, 3.0]
    )


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"fps": 0.0}, "frames a second are possible, got 0"),
        ({"fps": 25, "speed": -1.0}, "a speed above 0"),
        ({"fps": 25, "speed": 1e-6}, "would be 25000001 frames"),
    ],
)
def test_rates_that_cannot_be_are_refused(wrong, message):
    with pytest.raises(UsageError, match=message):
        frame_times(0.0, 1.0, **wrong)


def pictures(count, size=(48, 32)):
    for k in range(count):
        yield Image.new("RGB", size, (10 * k, 200, 255 - 10 * k))


def told(path):
    with Image.open(path) as film:
        return getattr(film, "n_frames", 1), film.size


@pytest.mark.parametrize("ending", [".gif", ".webp"])
def test_an_animation_holds_every_frame_and_its_whole_time(tmp_path, ending):
    path = tmp_path / f"film{ending}"
    done = []
    assert write_film(path, pictures(7), 7, fps=30, progress=lambda k, n: done.append((k, n))) == 7
    assert told(path) == (7, (48, 32)) and done == [(k, 7) for k in range(1, 8)]
    with Image.open(path) as film:
        shown = []
        for k in range(7):
            film.seek(k)
            film.load()
            shown.append(film.info["duration"])
    assert sum(shown) == pytest.approx(1000 * 7 / 30, abs=10)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("ending", [".gif", ".webp", ".mp4"])
def test_the_same_frames_give_the_same_bytes(tmp_path, ending):
    if ending == ".mp4":
        pytest.importorskip("imageio_ffmpeg")
    for name in ("one", "two"):
        write_film(tmp_path / f"{name}{ending}", pictures(5), 5, fps=25)
    assert (tmp_path / f"one{ending}").read_bytes() == (tmp_path / f"two{ending}").read_bytes()


def mp4_frames(path):
    """What ffmpeg says of the stream, and how many frames it decodes."""
    from imageio_ffmpeg import get_ffmpeg_exe

    done = subprocess.run(
        [get_ffmpeg_exe(), "-i", str(path), "-f", "framemd5", "-"], capture_output=True, check=True
    )
    frames = [
        line for line in done.stdout.decode().splitlines() if line and not line.startswith("#")
    ]
    return done.stderr.decode(), len(frames)


def test_an_mp4_of_odd_size_plays_with_its_rate_and_frames(tmp_path):
    pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "film.mp4"
    write_film(path, pictures(12, (47, 33)), 12, fps=24)
    said, frames = mp4_frames(path)
    assert "h264" in said and "48x34" in said and "24 fps" in said and frames == 12


@pytest.mark.parametrize("ending", [".gif", ".webp", ".mp4"])
def test_a_stopped_film_holds_the_finished_part_and_says_so(tmp_path, ending):
    if ending == ".mp4":
        pytest.importorskip("imageio_ffmpeg")

    def stopped_after(count):
        yield from pictures(count)
        raise KeyboardInterrupt

    path = tmp_path / f"film{ending}"
    with pytest.raises(KeyboardInterrupt, match="stopped after 3 of 9 frames"):
        write_film(path, stopped_after(3), 9, fps=25)
    assert (mp4_frames(path)[1] if ending == ".mp4" else told(path)[0]) == 3
    with pytest.raises(KeyboardInterrupt):
        write_film(tmp_path / f"none{ending}", stopped_after(0), 9, fps=25)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_a_film_that_fails_leaves_nothing(tmp_path):
    def broken():
        yield from pictures(2)
        raise InputError("no such pose")

    with pytest.raises(InputError, match="no such pose"):
        write_film(tmp_path / "film.gif", broken(), 9, fps=25)
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        write_film(tmp_path / "file" / "film.gif", pictures(2), 2, fps=25)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize(
    ("name", "fps", "message"),
    [
        ("film.avi", 25, "a film is a .mp4, .gif or .webp"),
        ("film.gif", 60, "0.1 to 50 frames a second, got 60"),
    ],
)
def test_what_no_film_can_be_is_refused(tmp_path, name, fps, message):
    with pytest.raises(UsageError, match=message):
        write_film(tmp_path / name, pictures(1), 1, fps=fps)


def test_mp4_without_its_encoder_names_the_package_and_exits_with_4(tmp_path):
    code = (
        "import sys; sys.modules['imageio_ffmpeg'] = None\n"
        "from pathlib import Path; from PIL import Image; from workbench.draw.films.film import write_film\n"
        "from workbench.errors import MissingPartError\n"
        "try: write_film(Path('film.mp4'), iter([Image.new('RGB', (8, 8))]), 1, fps=25)\n"
        "except MissingPartError as error: print(error.exit_code, error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=True,
        env={"PYTHONPATH": str(ROOT)},
    )
    assert done.stdout.startswith("4 MP4 films need imageio-ffmpeg: pip install") and not list(
        tmp_path.iterdir()
    )
    assert MissingPartError.exit_code == 4


def test_every_frame_of_a_motion_has_its_time_burnt_in(one_arm, swing):
    scene, times = moving(one_arm, swing)
    frames = list(
        film_frames(
            scene, front(120), times, lambda s, c: disks(s, c, supersample=1), stamp="1/10 speed"
        )
    )
    bare = [disks(scene_at(scene, k), front(120), supersample=1) for k in range(5)]
    for frame, alone in zip(frames, bare, strict=True):
        changed = np.any(np.asarray(frame) != np.asarray(alone), axis=2)
        assert changed[:30].any() and not changed[30:].any()
    assert (
        np.asarray(stamp_text(bare[0].copy(), "0.000 s")).tolist() != np.asarray(frames[1]).tolist()
    )


def test_the_camera_of_a_film_holds_every_pose(one_arm, swing):
    scene, _ = moving(one_arm, swing, 30)
    whole = every_pose(scene, most=10)
    assert len(whole.bodies) == 10 and whole.bounds[1, 0] > 1.0 > scene.bounds[1, 0]


def test_ghosts_are_drawn_pale_behind_and_never_over_a_body():
    ghost = spheres_body([0.2, 0.3, 0], 0.4)
    body = spheres_body([0, -0.3, 0], 0.4)  # the ghost stands in front
    plain, seen = (
        np.asarray(disks(Scene((body,), ghosts=g), front(128), supersample=1)).astype(int)
        for g in ((), (ghost,))
    )
    changed = np.any(plain != seen, axis=2)
    over = np.any(plain < 255, axis=2)
    assert changed.any() and not (changed & over)[:100].any()  # the scale bar is below row 100
    assert seen[64, 90].min() > 120  # pale


def test_later_ghosts_are_stronger_and_those_of_one_frame_alike():
    placed = crowd().placed
    many = Placed(
        placed.body,
        np.repeat(placed.world_from_segment, 3, 0),
        np.repeat(placed.centres, 3, 0),
        placed.window,
    )
    scene = Scene((), ghosts=tuple(SceneBody(many, k) for k in (0, 0, 1, 2)))
    strength = ghost_strengths(scene)
    assert strength[0] == strength[1] < strength[2] < strength[3] < 1.0
    trail = scene_at(Scene((SceneBody(many),)), 2, trail=5)
    assert [g.pose for g in trail.ghosts] == [0, 1] and trail.bodies[0].pose == 2


def test_a_strip_holds_its_pictures_side_by_side_with_their_text(one_arm, swing):
    scene, _ = moving(one_arm, swing, 4)
    captions = ["0 ms", "50 ms", "<b>", "150 ms"]
    root = ElementTree.fromstring(
        strip_svg([circles(scene_at(scene, k), front(100)) for k in range(4)], captions)
    )
    panels = [item for item in root if item.tag == SVG + "svg"]
    assert [panel.get("x", "0") for panel in panels] == ["0", "108", "216", "324"]
    assert [item.text for item in root if item.tag == SVG + "text"] == captions
    image = strip_image([Image.new("RGB", (50, 60), (0, 0, 0))] * 4, captions)
    assert image.size == (4 * 58 - 8, 86)
    with pytest.raises(UsageError, match="one size and a caption each"):
        strip_image([Image.new("RGB", (50, 60)), Image.new("RGB", (51, 60))], ["", ""])


def test_a_gif_of_a_scene_can_be_read_back(one_arm, swing, tmp_path):
    scene, times = moving(one_arm, swing)
    frames = film_frames(scene, front(64), times, lambda s, c: disks(s, c, supersample=1))
    write_film(tmp_path / "arm.gif", frames, len(times), fps=5)
    assert told(io.BytesIO((tmp_path / "arm.gif").read_bytes())) == (5, (64, 64))


def test_the_environment_is_opened_by_one_plane_in_all_frames_of_a_film(tmp_path):
    source = build_source("trainer_crash")
    look = parse_display_options(tmp_path / "x.gif", view="left", size="64x48")
    every = every_pose(source.scene)
    camera = camera_for_all_poses(source, look)
    cuts = {
        cut_depth(projected_disks(scene_at(source.scene, k), camera), camera)
        for k in (0, 80, 110, 199)
    }
    assert len(cuts) == 1 and cuts == {cut_depth(projected_disks(every, camera), camera)}
