"""The live bench: who may reach its server, what it takes, and what it answers."""

from __future__ import annotations

import asyncio
import base64
import json
import shutil
import socket
import subprocess
import sys
import threading
import time
import zlib
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from tests.web_page import served
from workbench.cli import main
from workbench.errors import InputError, has_controls
from workbench.live.frames import place_of_finding
from workbench.live.pages import MOST_ASKED, MOST_WAITING, TOO_MUCH, Page, PageClosedError, Waiting
from workbench.live.protocol import LONGEST, SUBPROTOCOL, Question, packed, parsed, unpacked
from workbench.model.result import Finding
from workbench.study.bench.answers import judged

pytest.importorskip("starlette", reason="the extra `live` is not installed")
pytest.importorskip("httpx2", reason="Starlette's test client needs httpx2")
pytest.importorskip("uvicorn", reason="the extra `live` is not installed")

from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from workbench.live.desk import Desk
from workbench.live.server import live_application
from workbench.report.running import run_and_write

PORT = 8123
TOKEN = "a-secret-of-the-tests"
HOST = f"127.0.0.1:{PORT}"
SOCKET = f"ws://{HOST}/ws"
PAIR = {"do": "criterion", "person": "pilot", "segment": "H", "part": "canopy", "at_least": 0.01}
PAGES = (
    "/",
    "/page/app.js",
    "/page/connection.js",
    "/page/people.js",
    "/page/person.js",
    "/page/size.js",
    "/page/picture.js",
    "/page/things.js",
    "/page/style.css",
    "/view/panel.js",
    "/view/view.css",
    "/scene",
    "/favicon.ico",
)
FILES = (
    "app.js",
    "describe.css",
    "describe.html",
    "describe.js",
    "describe_frame.js",
    "describe_marks.js",
    "describe_next.js",
    "describe_parts.js",
    "describe_things.js",
    "connection.js",
    "copying.js",
    "elements.js",
    "envelope.js",
    "eye.js",
    "field.js",
    "far_painting.js",
    "filming.js",
    "ghost.js",
    "gizmo.js",
    "grips.js",
    "keys.js",
    "progress.js",
    "sliders.js",
    "looks.js",
    "measure.js",
    "motion.js",
    "painter.js",
    "people.js",
    "person.js",
    "picture.js",
    "reach_map.js",
    "reporting.js",
    "rows.js",
    "size.js",
    "things.js",
    "verdicts.js",
    "ways.js",
    "index.html",
    "style.css",
    "icon.svg",
)


def film_of_size(width, height):
    """A question for a film of so many pixels."""
    view = {"eye": [4, 3, 3], "at": [0, 0, 1], "angle": 0.5, "width": width, "height": height}
    return json.dumps({"do": "film", **view})


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("bench") / "trainer.yaml"
    shutil.copy(ROOT / "tests" / "data" / "two_men.yaml", path)
    return path


@pytest.fixture(scope="module")
def desk(study):
    return Desk(str(study))


@pytest.fixture
def client(desk):
    desk.open()
    with client_of(desk) as found:
        yield found


def client_of(desk, host=HOST, runner=run_and_write):
    app = live_application(desk, port=PORT, token=TOKEN, runner=runner)
    return TestClient(app, base_url=f"http://{host}", follow_redirects=False)


def entered(client):
    assert client.get(f"/?token={TOKEN}").status_code == 303
    return client


def page_of(client, **headers):
    given = {"origin": f"http://{HOST}", **headers}
    return client.websocket_connect(SOCKET, subprotocols=[SUBPROTOCOL], headers=given)


def frames_until(page, kind, most=30, never=""):
    for _ in range(most):
        head, arrays = unpacked(page.receive_bytes())
        if head["kind"] == kind:
            return head, arrays
        assert head["kind"] != never
    raise AssertionError(f"no {kind} among {most} frames")


def asked(page, verb, **given):
    """The answer to a question, or the fault."""
    page.send_text(json.dumps({"n": 7, "do": verb, **given}))
    for _ in range(30):
        head, _ = unpacked(page.receive_bytes())
        if head.get("answers") == 7:
            return head
    raise AssertionError(f"no answer to {verb}")


# --- the picture ---------------------------------------------------------------------------------


def test_the_picture_holds_the_place_and_the_people_as_they_are(client, desk):
    entered(client)
    block = zlib.decompress(base64.b64decode(client.get("/scene").text), -15)
    length = int.from_bytes(block[:4], "little")
    (view,) = json.loads(block[4 : 4 + length])["views"]
    environment = desk.opened.study.environment
    shown = [
        name for name, gone in zip(environment.parts, environment.hidden, strict=True) if not gone
    ]
    assert [part["name"] for part in view["place"]["parts"]] == shown
    with page_of(client) as page:
        head, arrays = frames_until(page, "answer")
    assert [body["name"] for body in view["bodies"]] == [one["role"] for one in head["people"]]
    assert set(head["shifts"]) == {name for seat in environment.seats for name in seat.moves}
    for k, body in enumerate(view["bodies"]):
        assert len(arrays[f"centres{k}"]) == 3 * len(arrays[f"radius{k}"])
        assert len(body["segments"]) == len(arrays[f"room{k}"])


# --- who may reach it -------------------------------------------------------------------------------


@pytest.mark.parametrize("path", PAGES)
def test_nobody_gets_anything_without_the_cookie(client, path):
    assert client.get(path).status_code == 403


@pytest.mark.parametrize("path", PAGES)
def test_with_the_cookie_every_file_of_the_page_is_served(client, path):
    entered(client)
    found = client.get(path)
    assert found.status_code == 200 and found.content


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1:1", "localhost", f"127.0.0.1.evil:{PORT}"]
)
@pytest.mark.parametrize("path", [*PAGES, f"/?token={TOKEN}"])
def test_a_foreign_host_is_refused_even_with_the_cookie(client, host, path):
    entered(client)
    assert client.get(path, headers={"host": host}).status_code == 421


def test_the_token_becomes_a_cookie_and_leaves_the_address(client):
    found = client.get(f"/?token={TOKEN}")
    assert found.headers["location"] == "/"
    cookie = found.headers["set-cookie"]
    assert f"workbench-{PORT}=" in cookie
    assert all(word in cookie for word in ("HttpOnly", "SameSite=Strict", "Path=/"))


@pytest.mark.parametrize("token", ["", "wrong", TOKEN + "x", TOKEN[:-1], "%00"])
def test_a_wrong_token_is_refused(client, token):
    found = client.get(f"/?token={token}")
    assert found.status_code == 403 and "set-cookie" not in found.headers


FOREIGN = (
    "a b=c",
    "{json}=[1,2]",
    "x@y=1",
    "a=\u00ff",
    '"',
    "=",
    'a="b;',
    "path=/; a",
    "A" * 70_000,
)
"""Cookies that other programs of this machine may have set, which have the same host."""


@pytest.mark.parametrize("foreign", FOREIGN)
def test_cookies_of_other_programs_lock_nobody_out(client, foreign):
    own = f"workbench-{PORT}={TOKEN}"
    for given in (f"{foreign}; {own}", f"{own}; {foreign}", f"workbench-{PORT}=old; {own}"):
        headers = {"cookie": given.encode("latin-1")}
        assert client.get("/page/app.js", headers=headers).status_code == 200
    assert client.get("/", headers={"cookie": foreign.encode("latin-1")}).status_code == 403
    close = f"workbench-{PORT}={TOKEN}x"
    assert client.get("/", headers={"cookie": close}).status_code == 403


def test_the_cookie_of_another_port_opens_nothing(client):
    client.cookies.set("workbench-9999", TOKEN)
    assert client.get("/").status_code == 403


@pytest.mark.parametrize(
    "path", [*PAGES, "/nowhere", "/page/../server.py", "/page/%2e%2e%2fserver.py"]
)
def test_every_answer_carries_the_policy(client, path):
    for who in (client, entered(client)):
        headers = who.get(path).headers
        assert "script-src 'self'" in headers["content-security-policy"]
        assert "unsafe" not in headers["content-security-policy"]
        assert headers["cache-control"] == "no-store"
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["cross-origin-resource-policy"] == "same-origin"


@pytest.mark.parametrize("path", ["/nowhere", "/page/server.py", "/page/%2e%2e%2fserver.py"])
def test_files_that_are_no_part_of_the_page_are_not_served(client, path):
    assert entered(client).get(path).status_code == 404


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS"])
def test_nothing_but_get_is_served(client, method):
    assert entered(client).request(method, "/").status_code == 405


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": f"https://{HOST}"},
        {"origin": f"http://{HOST}", "host": "evil.example"},
    ],
)
def test_a_socket_of_a_foreign_page_is_refused(client, headers):
    entered(client)
    with pytest.raises(WebSocketDisconnect), page_of(client, **headers):
        pass


def test_a_socket_without_the_cookie_is_refused(client):
    with pytest.raises(WebSocketDisconnect), page_of(client):
        pass


def test_a_page_of_another_version_is_told_to_reload(client):
    entered(client)
    headers = {"origin": f"http://{HOST}"}
    with (
        pytest.raises(WebSocketDisconnect) as closed,
        client.websocket_connect(SOCKET, subprotocols=["workbench-0"], headers=headers),
    ):
        pass
    assert closed.value.code == 4400


def test_the_page_asks_for_nothing_from_elsewhere_and_holds_no_script():
    folder = ROOT / "workbench" / "live" / "page"
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES)
    text = (folder / "index.html").read_text()
    assert "http" not in text and "<script src=" in text and "style=" not in text
    for script in folder.glob("*.js"):
        lines = script.read_text()
        assert "innerHTML" not in lines and "eval" not in lines
        assert lines.count("\n") <= 250


def test_a_state_that_cannot_be_judged_is_reported(desk):
    desk.open()
    asked = desk.judgement()
    (frame,) = desk.take(asked, "there is a reason")
    assert unpacked(frame)[0]["words"] == "no verdicts: there is a reason"
    desk.do(parsed(json.dumps(TURN)))
    assert desk.take(asked, "there is a reason") == []


# --- what it takes ----------------------------------------------------------------------------------

TURN = {"n": 1, "do": "joint", "person": "pilot", "joint": "RE", "axis": 0, "degrees": 60}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "a message is JSON"),
        ("[]", "a JSON object"),
        ("[" * 20_000, "a message is JSON"),
        ('{"do": "fly"}', "nothing is called 'fly'"),
        ('{"do": ["joint"]}', "nothing is called"),
        ('{"n": 1}', "'do' is missing: expected one of joint, hand, "),
        ('{"n": -1, "do": "undo"}', "n: a whole number"),
        ('{"n": true, "do": "undo"}', "n: a whole number"),
        ('{"do": "undo", "by": 1}', "undo takes no 'by'"),
        (json.dumps({**TURN, "degrees": float("nan")}), "NaN is no number"),
        (json.dumps({**TURN, "degrees": float("inf")}), "Infinity is no number"),
        (json.dumps({**TURN, "degrees": 1}).replace(": 1,", ": 1e999,", 1), "too large"),
        (json.dumps({**TURN, "degrees": "60"}), "expected a number of degrees"),
        (json.dumps({**TURN, "degrees": True}), "expected a number of degrees"),
        (json.dumps({**TURN, "axis": 3}), "expected 0, 1 or 2"),
        (json.dumps({**TURN, "axis": True}), "expected 0, 1 or 2"),
        (json.dumps({**TURN, "person": "x" * 500}), "expected the name of a person"),
        ('{"do": "seat", "person": "pilot", "forward": 0}', "'up' is missing"),
        (
            '{"do": "hand", "person": "pilot", "limb": "tail", "target": [0, 0, 0]}',
            "expected a hand or foot",
        ),
        (
            '{"do": "hand", "person": "p", "limb": "left hand", "target": [0, 0]}',
            "expected three numbers of metres",
        ),
        ('{"do": "move", "parts": "compass", "by": [0, 0, 0]}', "a list of names of parts"),
        ('{"do": "move", "parts": [1], "by": [0, 0, 0]}', "a list of names of parts"),
        ('{"do": "move", "parts": ["compass"], "by": [0, 0, NaN]}', "NaN is no number"),
        ('{"do": "move", "parts": ["compass"]}', "'by' is missing"),
        ('{"do": "size", "person": "a", "sex": "nobody"}', "expected male or female"),
        ('{"do": "size", "person": "a", "measures": {"stature": NaN}}', "NaN is no number"),
        ('{"do": "size", "person": "a", "measures": {"stature": "1"}}', "metres by the name"),
        ('{"do": "size", "person": "a", "measures": [1]}', "metres by the name of a measure"),
        ('{"do": "size", "person": "a", "percentiles": {"": 5}}', "percentiles by the name"),
        ('{"do": "size", "person": "a", "mass": 1e999}', "too large"),
        ('{"do": "size", "person": "a", "age": true}', "a number of years"),
        ('{"do": "clothes", "person": "a", "clothes": "hat"}', "a list of names of clothes"),
        ('{"do": "clothes", "person": "a"}', "'clothes' is missing"),
        ('{"do": "harness", "person": "a", "zone": 4}', "expected 1, 2 or 3"),
        (film_of_size(0, 0), "film: width: expected a number of pixels from 1 on"),
        (film_of_size(640, 0), "film: height: expected a number of pixels from 1 on"),
        ('{"do": "predict", "person": "a", "like": "b", "holds": {"c": 1}}', "controls by limb"),
        ('{"do": "mirror"}', "'person' is missing"),
        ("x" * (LONGEST + 1), "at most 65536 bytes"),
    ],
)
def test_a_message_that_is_wrong_says_why(text, words):
    with pytest.raises(InputError, match=words):
        parsed(text)


def test_a_message_that_is_right_is_complete():
    question = parsed(json.dumps(TURN))
    assert question.given == {**{k: TURN[k] for k in TURN if k not in ("n", "do")}, "done": True}
    assert question.subject == parsed(json.dumps({**TURN, "degrees": 1, "done": False})).subject


def test_arrays_come_out_as_they_were_packed():
    one = np.arange(7, dtype=np.float32)
    other = np.array([1, 65535], dtype=np.uint16)
    head, arrays = unpacked(packed({"kind": "a – b"}, [("one", one), ("other", other)]))
    assert head == {"kind": "a – b"}
    assert np.array_equal(arrays["one"], one) and np.array_equal(arrays["other"], other)


def test_the_newest_of_a_drag_waits_and_its_end_is_never_lost():
    waiting = Waiting()
    for degrees, done in ((1, False), (2, False), (3, True), (4, False), (5, False)):
        waiting.put("a", parsed(json.dumps({**TURN, "degrees": degrees, "done": done})))
    waiting.put("b", parsed(json.dumps({**TURN, "degrees": 9, "done": False})))
    waiting.forget("b")
    assert [waiting.take()[1].given["degrees"] for _ in range(len(waiting))] == [3, 5]


def test_too_many_questions_are_refused():
    waiting = Waiting()
    for _ in range(MOST_WAITING):
        waiting.put("a", parsed('{"do": "undo"}'))
    with pytest.raises(InputError, match="wait already"):
        waiting.put("a", parsed('{"do": "undo"}'))


def test_who_asks_much_makes_nobody_else_wait():
    waiting = Waiting()
    for _ in range(MOST_WAITING):
        waiting.put("a", parsed('{"do": "undo"}'))
    for asker in ("b", "c"):
        waiting.put(asker, parsed('{"do": "redo"}'))
    assert [waiting.take()[0] for _ in range(4)] == ["a", "b", "c", "a"]
    assert len(waiting) == MOST_WAITING - 2


def test_a_page_that_asks_without_end_is_closed_and_others_are_answered(client, monkeypatch):
    entered(client)
    with page_of(client) as other:
        assert asked(other, "undo")["kind"] == "answer"
        with monkeypatch.context() as patched, page_of(client) as page:
            frames_until(page, "answer")
            patched.setattr("workbench.live.pages.MOST_ASKED", 0)
            page.send_text("junk")
            with pytest.raises(WebSocketDisconnect) as closed:
                frames_until(page, "fault")
        assert closed.value.code == TOO_MUCH
        assert asked(other, "undo")["kind"] == "answer"


def test_messages_are_counted_by_the_second():
    page = Page(Deaf())
    for second in (1.0, 2.0):
        for _ in range(MOST_ASKED):
            page.count(second)
    with pytest.raises(PageClosedError, match="500 times a second"):
        page.count(2.5)


class Deaf:
    """A socket that takes nothing."""

    async def send_bytes(self, data):
        await asyncio.Event().wait()


@pytest.mark.parametrize(
    ("limit", "words"), [("SLOWEST", "takes no answers"), ("MOST_UNSENT", "too slowly")]
)
def test_a_page_that_takes_no_answers_is_given_up(monkeypatch, limit, words):
    monkeypatch.setattr(f"workbench.live.pages.{limit}", 0.01)

    async def delivered():
        page = Page(Deaf())
        page.put(b"one")
        page.put(b"two")
        await page.deliver()

    with pytest.raises(PageClosedError, match=words):
        asyncio.run(delivered())


# --- what it answers --------------------------------------------------------------------------------


def test_a_page_is_greeted_and_gets_the_state_and_the_verdicts(client):
    with page_of(entered(client)) as page:
        hello, _ = frames_until(page, "hello")
        assert hello["title"] == "Two median men in the trainer" and hello["saves"]
        head, arrays = frames_until(page, "answer")
        assert arrays["centres0"].size == 3 * hello["people"][0]["spheres"]
        assert arrays["room0"].size == len(hello["people"][0]["segments"])
        assert head["case"] == "cruise" and not head["undo"] and not head["unsaved"]
        verdicts, _ = frames_until(page, "verdicts")
        assert verdicts["passed"] and len(verdicts["rows"]) == 6
        assert all(row["point"] and row["person"] for row in verdicts["rows"])


def test_a_finding_without_a_point_is_looked_at_at_its_control_or_joint(desk):
    there = judged(desk.opened, desk.live).there
    throttle = next(one for one in there.environment.controls if one.name == "throttle")
    reach = Finding(
        "cruise", "pilot", "", "the right hand", "throttle in zone 1", 0.1, 0.0, about="throttle"
    )
    assert place_of_finding(reach, there) == pytest.approx(tuple(throttle.at))
    missed = replace(reach, target="throttle, limited by right elbow flexion")
    assert place_of_finding(missed, there) == pytest.approx(tuple(throttle.at))
    stop = replace(reach, subject="right elbow", target="flexion", about="")
    situation = there.situations[0][0]
    elbow = situation.body.joint_names.index("right elbow")
    segment = int(situation.body.parent[elbow + 1])
    parent = wb.place(situation.body, situation.poses).world_from_segment[0, segment]
    at = parent[:, :3] @ situation.body.joint_in_parent[0, elbow] + parent[:, 3]
    assert place_of_finding(stop, there) == pytest.approx(tuple(at), abs=1e-9)
    over = replace(stop, subject="the eyes", target="canopy")
    eyes = [situation.body.sphere_names.index(f"{side} eye") for side in ("left", "right")]
    middle = situation.placed.centres[0, eyes].mean(axis=0)
    assert place_of_finding(over, there) == pytest.approx(tuple(middle), abs=1e-9)
    assert place_of_finding(replace(reach, target="the travel", about=""), there) is None


def test_a_turned_joint_is_answered_undone_and_judged(client):
    with page_of(entered(client)) as page:
        frames_until(page, "verdicts")
        head = asked(page, "joint", person="pilot", joint="RE", axis=0, degrees=140.0)
        assert head["undo"] and head["unsaved"] and head["generation"] > 1
        elbow = next(k for k, j in enumerate(hello_joints(page, client)) if j == "RE")
        assert head["people"][0]["angles"][elbow][0] == 140.0
        verdicts, _ = frames_until(page, "verdicts")
        assert verdicts["generation"] == head["generation"]
        back = asked(page, "undo")
        assert not back["unsaved"] and back["redo"]
        assert asked(page, "redo")["people"][0]["angles"][elbow][0] == 140.0


def test_a_joint_that_would_turn_nothing_has_no_slider(client):
    """Somebody who sits is put there by the lower torso; the pelvis joint bears all of the body."""
    with page_of(entered(client)) as page:
        hello, _ = frames_until(page, "hello")
        pelvis, waist, *_ = hello["people"][0]["joints"]
        assert (pelvis["joint"], pelvis["axes"]) == ("PV", [None, None, None])
        assert all(waist["axes"])


def hello_joints(page, client):
    with page_of(client) as other:
        hello, _ = frames_until(other, "hello")
    return [joint["joint"] for joint in hello["people"][0]["joints"]]


FAULTS = [
    (
        {"do": "joint", "person": "x", "joint": "RE", "axis": 0, "degrees": 1},
        "nobody is called 'x'",
    ),
    ({"do": "joint", "person": "pilot", "joint": "RE", "axis": 0, "degrees": 1e9}, "-180 to 180"),
    ({"do": "hand", "person": "pilot", "limb": "left hand", "target": [1e9, 0, 0]}, "within 10 m"),
    ({"do": "hand", "person": "pilot", "limb": "left hand"}, "a target or a control is needed"),
    ({"do": "hand", "person": "pilot", "limb": "left hand", "control": "x"}, "no control 'x'"),
    ({"do": "seat", "person": "pilot", "forward": 9, "up": 0}, "the travel of seat left is"),
    ({"do": "case", "name": "flight"}, "no case 'flight'"),
    ({"do": "move", "by": [0, 0, 0]}, "parts or controls must be named"),
    ({"do": "move", "parts": ["a"], "controls": ["b"], "by": [0, 0, 0]}, "one of the two"),
    ({"do": "move", "parts": ["compas"], "by": [0, 0, 0]}, "no part 'compas'"),
    ({"do": "move", "controls": ["flap"], "by": [0, 0, 0]}, "did you mean 'flaps'"),
    ({"do": "move", "parts": ["left_seat_pan"], "by": [0, 0, 0]}, "move the seat instead"),
    ({"do": "move", "parts": ["compass"], "by": [0, 1e6, 0]}, "up to 10 m"),
    ({"do": "harness", "person": "pilot", "zone": 1}, "no criterion asks what pilot reaches"),
    ({"do": "posture", "person": "pilot", "name": "fly"}, "did you mean 'flying'"),
    ({"do": "mirror", "person": "x"}, "nobody is called 'x'"),
    ({"do": "save", "to": "../a.yaml"}, "a name such as"),
    ({"do": "save", "to": ".hidden.yaml"}, "a name such as"),
    ({"do": "save", "to": "two\nlines.yaml"}, "a name such as"),
    ({"do": "save", "to": "two\u2028lines.yaml"}, "a name such as"),
    ({"do": "save", "to": " a.yaml"}, "a name such as"),
    ({"do": "save", "to": f"{'a' * 300}.yaml"}, "a name such as"),
    ({**PAIR, "name": "x" * 300}, "a criterion needs a name of 1 to 80 characters"),
    ({**PAIR, "name": "\u2028"}, "a criterion needs a name of 1 to 80 characters"),
    ({**PAIR, "name": "a\u202eb"}, "a criterion needs a name of 1 to 80 characters"),
]


@pytest.mark.parametrize(("message", "words"), FAULTS)
def test_what_cannot_be_done_is_reported_and_changes_nothing(client, desk, message, words):
    with page_of(entered(client)) as page:
        frames_until(page, "answer")
        before = desk.live.people, desk.generation
        fault = asked(page, message.pop("do"), **message)
        assert fault["kind"] == "fault" and words in fault["words"]
        assert (desk.live.people, desk.generation) == before


@pytest.mark.parametrize("text", ["no JSON", '{"do": "fly"}', "x" * (LONGEST + 1), '{"do": NaN}'])
def test_a_wrong_message_is_reported_and_the_socket_stays(client, text):
    with page_of(entered(client)) as page:
        page.send_text(text)
        assert frames_until(page, "fault")[0]["words"]
        page.send_bytes(b"\xff\xfe")
        assert "JSON" in frames_until(page, "fault")[0]["words"]
        assert asked(page, "undo")["kind"] == "answer"


def test_a_part_is_moved_with_its_control_and_undone(client, desk):
    with page_of(entered(client)) as page:
        frames_until(page, "verdicts")
        names = [one.name for one in desk.opened.study.environment.controls]
        throttle = names.index("throttle")
        head = asked(page, "move", parts=["throttle_lever"], by=[0.015, 0.0, 0.0])
        assert head["words"] == "throttle goes along" and head["unsaved"]
        assert head["shifts"]["throttle_lever"] == [0.015, 0.0, 0.0]
        assert head["moves"] == [
            {"parts": ["throttle_lever"], "controls": [], "by": [0.015, 0.0, 0.0]}
        ]
        at = desk.opened.study.environment.controls[throttle].at
        assert head["controls"][throttle] == pytest.approx([at[0] + 0.015, *at[1:]], abs=1e-5)
        verdicts, _ = frames_until(page, "verdicts")
        assert verdicts["generation"] == head["generation"]
        back = asked(page, "undo")
        assert not back["unsaved"] and back["moves"] == []
        assert "throttle_lever" not in back["shifts"]


SLOW_FAULTS = [
    ({"do": "size", "person": "x", "sex": "male"}, "nobody is called 'x'"),
    (
        {"do": "size", "person": "pilot", "sex": "male", "measures": {"stature": 9.6}},
        "9600 mm is not a person's",
    ),
    (
        {"do": "size", "person": "pilot", "sex": "male", "measures": {"statur": 1.6}},
        "did you mean 'stature'",
    ),
    (
        {
            "do": "size",
            "person": "pilot",
            "sex": "male",
            "measures": {"stature": 1.7, "sitting_height": 0.5},
        },
        "no such person",
    ),
    (
        {"do": "size", "person": "pilot", "sex": "male", "percentiles": {"stature": 101}},
        "between 0 and 100",
    ),
    ({"do": "clothes", "person": "pilot", "clothes": ["hat"]}, "no bodies/encumbrance entry"),
    ({"do": "predict", "person": "pilot", "like": "sleeping"}, "no posture 'sleeping'"),
    (
        {
            "do": "predict",
            "person": "pilot",
            "like": "driving",
            "holds": {"left hand": "left_seat_left_pedal"},
        },
        "is for feet, not for the left hand",
    ),
    ({"do": "free", "person": "pilot"}, "given in case 'cruise'"),
]


@pytest.mark.parametrize(("message", "words"), SLOW_FAULTS)
def test_what_takes_time_and_cannot_be_done_is_reported_in_one_sentence(
    client, desk, message, words
):
    with page_of(entered(client)) as page:
        frames_until(page, "answer")
        given = {name: value for name, value in message.items() if name != "do"}
        busy = asked(page, message["do"], **given)
        assert busy["kind"] == "busy" and message["person"] in busy["what"]
        fault, _ = frames_until(page, "fault", never="answer")
        assert words in fault["words"] and "\n" not in fault["words"]
        assert not desk.unsaved and not desk.history.can_undo


def test_a_person_gets_another_body_while_the_desk_answers(client, desk):
    with page_of(entered(client)) as page:
        hello, _ = frames_until(page, "hello")
        assert (
            "helmet" in hello["people"][0]["wearable"]
            and "flying" in hello["people"][0]["postures"]
        )
        before, _ = frames_until(page, "answer")
        assert before["people"][0]["size"] is None
        size = {"person": "pilot", "sex": "female", "percentiles": {"stature": 5}}
        assert asked(page, "size", **size)["what"] == "the body of pilot is being made"
        assert asked(page, "clothes", person="pilot", clothes=["helmet"])["kind"] == "busy"
        assert asked(page, "case", name="looking left")["kind"] == "answer"
        for _ in range(30):
            head, arrays = frames_until(page, "answer")
            if head["people"][0]["clothes"]:
                break
        person = head["people"][0]
        assert person["size"]["measures"]["stature"] == [1.525, pytest.approx(5.0, abs=0.3)]
        assert person["figure"] != before["people"][0]["figure"]
        assert head["case"] == "looking left" and head["unsaved"]
        assert len(arrays["radius0"]) > hello["people"][0]["spheres"]
        back = asked(page, "undo")
        assert back["people"][0]["clothes"] == [] and back["people"][0]["size"] is not None
        assert asked(page, "undo")["people"][0]["figure"] == before["people"][0]["figure"]
        assert not desk.unsaved


def test_a_state_without_an_answer_is_not_taken(desk, monkeypatch):
    desk.open()
    desk.state()
    before = desk.live

    def fails(*_, **__):
        raise InputError("there is no place")

    monkeypatch.setattr("workbench.live.desk.placed_people", fails)
    (fault,) = desk.do(parsed(json.dumps(TURN))).asker
    assert "there is no place" in unpacked(fault)[0]["words"]
    assert desk.live is before and not desk.history.can_undo


@pytest.mark.parametrize("loop", ["take", "watched"])
def test_a_loop_that_fails_is_reported_and_goes_on(client, desk, monkeypatch, loop):
    kept = getattr(desk, loop)
    failures = iter(["a frame that cannot be packed"])

    def fails_once(*given):
        for words in failures:
            raise ValueError(words)
        return kept(*given)

    monkeypatch.setattr(desk, loop, fails_once)
    with page_of(entered(client)) as page:
        fault, _ = frames_until(page, "fault")
        assert fault["words"] == "internal error: ValueError: a frame that cannot be packed"
        asked(page, "joint", person="pilot", joint="RE", axis=0, degrees=140.0)
        frames_until(page, "verdicts")


def test_a_question_that_fails_before_it_is_done_is_answered(client, desk, monkeypatch):
    def fails(question):
        raise ValueError("no place")

    monkeypatch.setattr(desk, "preparation", fails)
    with page_of(entered(client)) as page:
        assert asked(page, "undo")["words"] == "internal error: ValueError: no place"


def test_a_page_is_served_whose_state_cannot_be_shown(client, desk, monkeypatch):
    def fails():
        raise ValueError("no state")

    monkeypatch.setattr(desk, "state", fails)
    with page_of(entered(client)) as page:
        assert frames_until(page, "fault")[0]["words"] == "internal error: ValueError: no state"
        assert asked(page, "undo")["kind"] == "answer"


def test_two_pages_see_the_same(client):
    entered(client)
    with page_of(client) as one, page_of(client) as other:
        frames_until(one, "answer")
        frames_until(other, "answer")
        asked(one, "seat", person="pilot", forward=0.01, up=0.0)
        for _ in range(30):
            head, _ = frames_until(other, "answer")
            if head["unsaved"]:
                break
        assert head["people"][0]["forward"] == 0.01
        assert head["shifts"]["left_seat_pan"][0] == pytest.approx(0.01, abs=1e-5)


def test_a_page_that_closes_in_the_midst_of_an_answer_leaves_the_bench_as_it_was(client, desk):
    entered(client)
    with page_of(client) as page:
        for degrees in range(20, 60):
            text = {**TURN, "degrees": degrees, "done": degrees == 59}
            page.send_text(json.dumps(text))
    with page_of(client) as page:
        frames_until(page, "answer")
        head = asked(page, "case", name="looking left")
        assert head["case"] == "looking left"
        turned = [hello["angles"] for hello in head["people"]]
        assert len(turned) == 2 and len(desk.history.entries) <= 2


def test_a_study_is_saved_with_its_comments_and_undone_to_its_bytes(client, study):
    before = study.read_bytes()
    try:
        with page_of(entered(client)) as page:
            asked(page, "joint", person="pilot", joint="RE", axis=0, degrees=60.0)
            saved, _ = save_of(page)
            assert saved["file"] == study.name
            after = study.read_text()
            assert "{posture: flying, angles: {RE: {flexion: 60}}}" in after
            assert after.count("#") == before.decode().count("#")
            asked(page, "undo")
            save_of(page)
            assert study.read_bytes() == before
    finally:
        study.write_bytes(before)


def save_of(page):
    page.send_text(json.dumps({"n": 3, "do": "save"}))
    return frames_until(page, "saved")


def test_a_file_that_an_editor_changes_is_read_again_or_asked_about(study, desk):
    before = study.read_bytes()
    desk.open()
    try:
        study.write_text(before.decode().replace("RE: {flexion: 75}", "RE: {flexion: 70}"))
        assert not desk.watched().changed  # an editor may be in the middle of it
        assert desk.watched().changed and not desk.watched().everybody
        desk.do(parsed(json.dumps(TURN)))
        study.write_bytes(before)
        assert desk.watched().everybody == []
        (fault,) = desk.watched().everybody
        assert unpacked(fault)[0]["ask"] == "over"
        assert desk.watched().everybody == []
        (refused,) = desk.do(parsed('{"do": "save"}')).asker
        assert "has changed on the disk" in unpacked(refused)[0]["words"]
        assert unpacked(refused)[0]["ask"] == "over"
        desk.do(parsed('{"do": "reload"}'))
        assert not desk.unsaved
    finally:
        study.write_bytes(before)


def test_a_file_that_could_not_be_read_is_read_again_once_it_can(study, desk):
    before = study.read_bytes()
    changed = before.replace(b"RE: {flexion: 75}", b"RE: {flexion: 70}")
    desk.open()
    try:
        for half in (b"", b"study: ["):  # written in steps
            study.write_bytes(half)
            assert desk.watched().everybody == []
        assert desk.watched().everybody != []
        assert desk.watched().everybody == []
        study.write_bytes(changed)
        desk.watched()
        assert desk.watched().changed
        study.write_bytes(b"")
        desk.watched()
        assert desk.watched().everybody != []
        study.write_bytes(changed)  # put back: it is what is open
        assert not any(desk.watched().asker or desk.watched().everybody for _ in range(2))
        desk.do(parsed(json.dumps(TURN)))
        (saved, _) = desk.do(parsed('{"do": "save"}')).everybody
        assert unpacked(saved)[0]["kind"] == "saved"
    finally:
        study.write_bytes(before)


def test_a_study_of_the_catalogue_is_not_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    desk = Desk("trainer_clearance")
    desk.do(parsed(json.dumps(TURN)))
    (fault,) = desk.do(parsed('{"do": "save"}')).asker
    assert "save it under another name" in unpacked(fault)[0]["words"]
    desk.do(parsed('{"do": "save", "to": "mine.yaml"}'))
    assert "RE: {flexion: 60}" in (tmp_path / "mine.yaml").read_text() and not desk.unsaved
    reading = Desk("mine.yaml", read_only=True)
    (fault,) = reading.do(parsed('{"do": "save", "to": "other.yaml"}')).asker
    assert "read only" in unpacked(fault)[0]["words"]


def test_the_command_serves_to_this_machine_alone_until_it_is_stopped(study):
    command = [sys.executable, "-m", "workbench", "live", str(study), "--no-browser", "--read-only"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        try:
            address = running.stdout.readline().strip()
            port = int(address.split(":")[2].split("/")[0])
            assert address.startswith("http://127.0.0.1:")
            for _ in range(100):
                try:
                    with socket.create_connection(("127.0.0.1", port), timeout=1) as open_socket:
                        open_socket.sendall(b"GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n")
                        assert open_socket.recv(20).startswith(b"HTTP/1.1 421")
                    break
                except ConnectionRefusedError:
                    time.sleep(0.1)
        finally:
            running.terminate()
            running.wait(20)


def asked_of(address, path, cookies="", **headers):
    """The beginning of the answer of a server at an address to one request."""
    port = int(address.split(":")[2].split("/")[0])
    lines = [f"GET {path} HTTP/1.1", f"Host: 127.0.0.1:{port}", f"Cookie: {cookies}"]
    lines += [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
    with socket.create_connection(("127.0.0.1", port), timeout=20) as asking:
        asking.sendall("\r\n".join([*lines, "", ""]).encode())
        return asking.recv(1000)


FEW_FILES = "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (400, 400))"


def test_among_a_thousand_half_open_connections_and_large_cookies_the_page_is_served(study):
    with served(study, FEW_FILES) as address:
        port = int(address.split(":")[2].split("/")[0])
        own = f"workbench-{port}={address.split('token=')[1]}"
        large = "; ".join(f"other{k}={'x' * 4000}" for k in range(30))
        socket_of = {
            "Upgrade": "websocket",
            "Connection": "Upgrade",
            "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==",
            "Sec_WebSocket_Version": "13",
            "Sec_WebSocket_Protocol": SUBPROTOCOL,
            "Origin": f"http://127.0.0.1:{port}",
        }
        assert asked_of(address, "/").startswith(b"HTTP/1.1 403")  # it is there
        with ExitStack() as stack:
            for number in range(1000):
                open_socket = socket.create_connection(("127.0.0.1", port), timeout=20)
                stack.enter_context(open_socket)
                if number % 50 == 49:
                    time.sleep(0.05)  # the system's own queue has 128 places
                if number % 2:
                    open_socket.sendall(b"GET / HTTP/1.1\r\nHost: ")
            begin = time.monotonic()
            answered = asked_of(address, "/page/app.js", f"{large}; {own}")
            assert answered.startswith(b"HTTP/1.1 200")
            upgraded = asked_of(address, "/ws", f"{large}; {own}", **socket_of)
            assert upgraded.startswith(b"HTTP/1.1 101")
            assert time.monotonic() - begin < 15.0


@pytest.mark.parametrize("port", ["70000", "-1"])
def test_the_command_refuses_a_port_that_there_is_not(study, port, capsys):
    assert main(["live", str(study), "--port", port]) == 2


def test_the_command_says_what_is_missing(study):
    code = (
        "import sys\nsys.modules['starlette'] = None\n"
        "from workbench.cli import main\nsys.exit(main(['live', sys.argv[1]]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(study)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 4 and "bubbleman-workbench[live]" in done.stderr


def test_of_two_benches_that_save_one_study_at_once_the_second_is_asked(tmp_path):
    path = tmp_path / "trainer.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    desks = [Desk(str(path)) for _ in range(2)]
    for number, desk in enumerate(desks):
        given = {"person": "pilot", "forward": 0.01 * (number + 1), "up": 0.0, "done": True}
        desk.do(Question(1, "seat", given))
    gate = threading.Barrier(2)

    def saved(desk):
        gate.wait()
        found = desk.do(Question(2, "save", {"sharing": "all", "over": False, "to": ""}))
        return unpacked((*found.everybody, *found.asker)[0])[0]

    with ThreadPoolExecutor(2) as pool:
        came = list(pool.map(saved, desks))
    assert sorted(head["kind"] for head in came) == ["fault", "saved"]
    assert next(head["ask"] for head in came if head["kind"] == "fault") == "over"
    won = [head["kind"] for head in came].index("saved")
    assert f"forward: {10 * (won + 1)}" in path.read_text()


@pytest.mark.parametrize("stem", ["a\u2028b", "two\nlines", "\u202etxt", "x" * 250])
def test_a_study_of_any_name_is_opened_saved_and_kept_and_its_name_steers_nothing(tmp_path, stem):
    path = tmp_path / f"{stem}.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    desk = Desk(str(path))
    seat = {"do": "seat", "person": "pilot", "forward": 0.01, "up": 0.0}
    desk.do(parsed(json.dumps(seat)))
    replies = desk.do(parsed('{"do": "save"}'))
    heads = [unpacked(frame)[0] for frame in (*desk.greeting(), *replies.everybody)]
    assert "saved" in [head["kind"] for head in heads]
    said = "".join(str(head.get(key, "")) for head in heads for key in ("file", "words"))
    assert not has_controls(said) and "forward: 10" in path.read_text()
    desk.do(parsed(json.dumps({**seat, "forward": 0.02})))
    assert desk.keep().startswith("what was not saved is in ")
    assert len(list(tmp_path.iterdir())) == 2
