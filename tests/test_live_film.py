"""Films that a page of the live bench asks for."""

from __future__ import annotations

import json
import tempfile

import numpy as np
import pytest
from PIL import Image

from workbench.errors import InputError, UsageError
from workbench.live.desk import Desk
from workbench.live.protocol import parsed, unpacked

pytest.importorskip("starlette", reason="the extra `live` is not installed")
pytest.importorskip("httpx2", reason="Starlette's test client needs httpx2")

from tests.test_live import asked, client_of, entered, frames_until, page_of

VIEW = {"eye": [4.0, 3.0, 3.0], "at": [0.3, 0.0, 0.8], "angle": 0.5, "width": 160, "height": 160}
LAP = "the lap belt alone"


@pytest.fixture(scope="module")
def posture():
    return Desk("trainer_clearance", read_only=True)


@pytest.fixture(scope="module")
def crash():
    return Desk("trainer_crash", read_only=True)


@pytest.fixture
def short(monkeypatch):
    """Films of two frames a second."""
    monkeypatch.setattr("workbench.live.looking.FPS", 2.0)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where films are written."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def film_of(desk, **more):
    question = {"n": 3, "do": "film", **VIEW, **more}
    return desk.do(parsed(json.dumps(question)))


def frames_in(path):
    """The number of frames of a film."""
    if path.suffix == ".mp4":
        reader = pytest.importorskip("imageio_ffmpeg")
        return reader.count_frames_and_secs(str(path))[0]
    with Image.open(path) as film:
        return film.n_frames


def written(desk, path, **more):
    """Write a film; what its progress says."""
    said = []
    film_of(desk, **more).film.take().write(path, lambda done, of: said.append((done, of)))
    return said


@pytest.mark.usefixtures("short")
def test_a_film_has_the_frames_that_are_said_and_goes_to_who_asked(posture, folder):
    with client_of(posture) as client:
        entered(client)
        with page_of(client) as page, page_of(client) as other:
            assert asked(page, "film", **VIEW)["what"] == "the film is being made"
            head = {"done": 0}
            while "file" not in head:
                head, _ = frames_until(page, "film")
            assert head["frames"] == 12
            fetched = client.get(f"/film/{head['file']}")
            assert fetched.headers["content-type"] in ("video/mp4", "image/webp")
            path = folder / f"fetched{head['ending']}"
            path.write_bytes(fetched.content)
            assert frames_in(path) == 12
            assert client.get("/film/..%2f..%2fetc%2fpasswd").status_code == 404
            assert client.get("/film/9.mp4").status_code == 404
            asked(page, "film", **VIEW, section=[0, 1, 90.0])
            assert "file" not in frames_until(page, "film")[0]
            assert "this plane misses it" in frames_until(page, "fault")[0]["words"]
            other.send_text('{"n": 5, "do": "film_end"}')  # nobody's: there is none
            assert "file" not in frames_until(other, "film")[0]
        client.cookies.clear()
        assert client.get(f"/film/{head['file']}").status_code == 403
    assert not list(folder.glob("workbench-film-*"))


def test_a_film_that_is_ended_leaves_no_file_and_answers_go_on(posture, folder):
    with client_of(posture) as client:
        entered(client)
        with page_of(client) as page:
            asked(page, "film", **VIEW)
            head, _ = frames_until(page, "film")
            assert head["of"] == 150 and head["done"] < 150
            answer = asked(
                page, "joint", person="pilot", joint="RE", axis=0, degrees=50, done=False
            )
            assert answer["kind"] == "answer"
            page.send_text('{"n": 8, "do": "film_end"}')
            while "done" in head:
                head, _ = frames_until(page, "film")
            assert "file" not in head
        (made,) = folder.glob("workbench-film-*")
    assert not made.exists() or not list(made.iterdir())


@pytest.mark.usefixtures("short")
def test_a_motion_is_filmed_through_the_page_s_camera_as_often_as_is_said(crash, tmp_path):
    said = written(crash, tmp_path / "seen.webp", case=LAP)
    assert said == [(k, 9) for k in range(1, 10)]
    assert frames_in(tmp_path / "seen.webp") == 9
    near = {"eye": [2.0, 1.5, 1.8]}
    written(crash, tmp_path / "near.webp", case=LAP, **near, width=320)
    inside = []
    for name in ("seen", "near"):
        with Image.open(tmp_path / f"{name}.webp") as film:
            inside.append(film.convert("RGB"))
    assert [one.size for one in inside] == [(160, 160), (320, 160)]
    ink = [np.mean(np.asarray(one).min(axis=2) < 230) for one in inside]
    assert 0.05 < ink[0] < ink[1]  # from nearer by, the cockpit takes more of the picture


@pytest.mark.usefixtures("short")
def test_what_is_hidden_on_the_page_is_not_filmed(posture, tmp_path):
    environment = posture.opened.study.environment
    written(posture, tmp_path / "all.webp")
    written(posture, tmp_path / "one.webp", hidden=list(environment.parts), without=["pilot"])
    ink = []
    for name in ("all", "one"):
        with Image.open(tmp_path / f"{name}.webp") as film:
            ink.append(np.mean(np.asarray(film.convert("RGB")).min(axis=2) < 230))
    assert 0.01 < ink[1] < 0.3 * ink[0]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"without": ["pilot", "instructor"]}, "show at least one"),
        ({"eyes": "nobody"}, "nobody is called 'nobody'|is not its eyes"),
        ({"section": [0, 1, 90.0]}, "this plane misses it"),
        ({"eye": VIEW["at"]}, "two finite points"),
    ],
)
def test_what_cannot_be_filmed_is_said_and_no_file_is_left(posture, tmp_path, more, words):
    with pytest.raises((InputError, UsageError), match=words):
        written(posture, tmp_path / "film.webp", **more)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("desk", "more", "words"),
    [
        ("posture", {"case": "flying"}, "no motion 'flying'"),
        ("crash", {}, "there is no posture to go round"),
        ("crash", {"case": "x"}, "no motion 'x'"),
    ],
)
def test_a_film_of_what_is_not_there_is_refused(request, desk, more, words):
    replies = film_of(request.getfixturevalue(desk), **more)
    head, _ = unpacked(replies.asker[0])
    assert head["kind"] == "fault" and words in head["words"] and replies.film is None


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"eye": [1, 2]}, "film: eye: expected three numbers"),
        ({"width": -3}, "film: width: expected a number of pixels"),
        ({"section": [3, 1, 0.5]}, "an axis, a side and a number of metres"),
        ({"speed": 2}, "film takes no 'speed'"),
    ],
)
def test_questions_for_films_are_checked(more, words):
    with pytest.raises(InputError, match=words):
        parsed(json.dumps({"do": "film", **VIEW, **more}))
