"""The bench that describes an environment: its protocol, and its page in Chromium where it is."""

from __future__ import annotations

import base64
import contextlib
import json
import threading
import time
import zlib

import numpy as np
import pytest

from tests.made_seat import SRP, corners, obj_text, seat_parts
from tests.web_page import CHROMIUM, launched, pixels, served
from workbench.cli import main
from workbench.files.environments import load_environment

pytest.importorskip("starlette", reason="the extra `live` is not installed")
pytest.importorskip("httpx2", reason="Starlette's test client needs httpx2")
pytest.importorskip("uvicorn", reason="the extra `live` is not installed")

from starlette.testclient import TestClient

from tests.test_live import (
    HOST,
    PORT,
    TOKEN,
    asked,
    client_of,
    entered,
    frames_until,
    page_of,
)
from workbench.live.describe_desk import DescribeDesk
from workbench.live.protocol import Question, unpacked
from workbench.live.server import live_application
from workbench.report.running import run_and_write

CUSHION = {"part": "pan", "start": [SRP[0] + 0.2, SRP[1], 3], "way": [0, 0, -1]}
BACK = {"part": "rest", "start": [3, SRP[1], SRP[2] + 0.3], "way": [-1, 0, 0]}


@pytest.fixture
def mesh(tmp_path):
    path = tmp_path / "cab.obj"
    path.write_text(obj_text(seat_parts()))
    return path


@pytest.fixture
def bench(mesh):
    desk = DescribeDesk(str(mesh))
    with client_of(desk) as client:
        entered(client)
        with page_of(client) as page:
            frames_until(page, "description")
            yield client, page, desk


def test_a_page_is_greeted_before_it_hears_what_all_are_told(bench, monkeypatch):
    """It comes while another page's question is being answered."""
    client, page, desk = bench
    begun = threading.Event()
    do = desk.do

    def slowly(question):
        begun.set()
        time.sleep(0.3)
        return do(question)

    monkeypatch.setattr(desk, "do", slowly)
    page.send_text(json.dumps({"n": 7, "do": "undo"}))
    assert begun.wait(10)
    with page_of(client) as late:
        assert unpacked(late.receive_bytes())[0]["kind"] == "hello"


def test_the_page_is_another_one_behind_the_same_guard(mesh):
    with client_of(DescribeDesk(str(mesh))) as client:
        assert client.get("/").status_code == 403
        entered(client)
        assert 'src="/page/describe.js"' in client.get("/").text
        assert client.get("/page/describe_parts.js").status_code == 200


def test_options_of_studies_and_of_environments_are_not_mixed(mesh, capsys):
    assert main(["live", "trainer_clearance", "--out", "x"]) == 2
    assert main(["live", str(mesh), "--size", "small"]) == 2
    assert "an environment has no people" in capsys.readouterr().err


def test_a_seat_and_a_control_are_picked_typed_over_saved_and_undone(bench, mesh):
    _, page, _ = bench
    first = asked(page, "face", seat="driver", surface="cushion", **CUSHION)
    assert first["words"] == (
        "driver: a cushion of 443 x 500 mm; now pick the back, or write a stool, which has none, into "
        "the file"
    )
    seat = asked(page, "face", seat="driver", surface="back", **BACK)["seats"][0]
    assert (seat["srp"], seat["cushion_angle"], seat["back_angle"]) == ([0.1, 0.2, 0.3], 10, 20)
    lever = {"part": "lever", "start": [0.62, 0.02, 2], "way": [0, 0, -1]}
    found = asked(page, "place", kind="control", name="gear", grip="pinch", zone=3, **lever)
    assert found["controls"][0]["at"] == [0.62, 0.02, 0.6]
    over = asked(page, "figure", kind="seat", name="driver", figure="forward", value=[-0.1, 0.1])
    assert over["seats"][0]["forward"] == [-0.1, 0.1]
    assert asked(page, "save")["kind"] == "saved"
    environment = load_environment(mesh.parent / "environment.yaml")
    assert environment.controls[0].grip == "pinch" and environment.controls[0].zone == 3
    assert environment.seat("driver").travel_forward == (-0.1, 0.1)
    for _ in range(4):
        back = asked(page, "undo")
    assert not back["seats"] and not back["undo"] and back["unsaved"]
    for _ in range(4):
        again = asked(page, "redo")
    assert not again["unsaved"] and again["seats"] == over["seats"]


def test_the_pieces_of_a_control_are_shown_and_stated_as_its_own(tmp_path):
    boxes = {
        "floor": corners((0, -0.5, 0), (2, 0.5, 0.01)),
        "PropCap": corners((0.44, 0.02, 0.2), (0.46, 0.04, 0.23)),
        "PropLever": corners((0.447, 0.028, 0.1), (0.453, 0.032, 0.199)),
    }
    path = tmp_path / "levers.obj"
    path.write_text(obj_text(boxes))
    with client_of(DescribeDesk(str(path))) as client:
        entered(client)
        with page_of(client) as page:
            frames_until(page, "description")
            asked(page, "mesh", row=0, length="m", up="z", forward="x")
            cap = {"part": "PropCap", "start": [0.45, 0.03, 3], "way": [0, 0, -1]}
            found = asked(page, "place", kind="control", name="prop", grip="grasp", zone=1, **cap)
            assert found["controls"][0]["pieces"] == [
                {"part": "PropLever", "beside": "PropCap", "why": "it is named like it (prop)"}
            ]
            alone = asked(page, "own", control="prop", parts=["PropCap"])["controls"][0]
            assert (alone["pieces"], alone["stated"]) == ([], True)
            again = asked(page, "own", control="prop", parts=[])["controls"][0]
            assert not again["stated"] and len(again["pieces"]) == 1
            asked(page, "own", control="prop", parts=["PropLever"])
            asked(page, "join", parts=["PropLever"], to="stalk")
            moved = asked(page, "place", kind="control", name="prop", grip="pinch", zone=1, **cap)
            assert moved["controls"][0]["pieces"] == [{"part": "stalk", "beside": "", "why": ""}]
            assert asked(page, "leave", parts=["stalk"])["kind"] == "fault"
            asked(page, "save")
    control = load_environment(tmp_path / "environment.yaml").controls[0]
    assert control.own_parts == ("PropCap", "stalk")


def test_the_picture_has_the_mesh_in_its_unit_and_a_person_beside(bench):
    client, page, _ = bench

    def view():
        block = zlib.decompress(base64.b64decode(client.get("/scene").text), -15)
        length = int.from_bytes(block[:4], "little")
        return json.loads(block[4 : 4 + length])["views"][0]

    shown = view()
    assert [part["name"] for part in shown["place"]["parts"]] == ["pan", "rest", "floor", "lever"]
    assert [body["name"] for body in shown["bodies"]] == ["person for scale"]
    before = asked(page, "rule", part="pan", rule="see_through", value=True)
    after = asked(page, "mesh", row=0, length="ft")
    assert after["scene"] != before["scene"] and after["size"][0] == pytest.approx(1.8 * 0.3048)
    asked(page, "mesh", row=0, length="m")
    asked(page, "leave", parts=["lever"])
    assert [part["name"] for part in view()["place"]["parts"]] == ["pan", "rest", "floor"]


def test_a_size_is_typed_a_guess_agreed_to_and_what_is_unfinished_said_at_saving(bench):
    _, page, _ = bench
    found = asked(page, "long", row=0, size=3.6)
    assert found["meshes"][0]["length"] == "2000 mm" and found["size"][0] == pytest.approx(3.6)
    asked(page, "undo")
    agreed = asked(page, "agree")
    assert agreed["meshes"][0]["how"] == ["chosen"] * 3 and agreed["unfinished"] == []
    asked(page, "face", seat="driver", surface="cushion", **CUSHION)
    asked(page, "rule", part="lever", rule="hidden", value=True)
    assert asked(page, "save")["kind"] == "saved"
    after, _ = frames_until(page, "description")
    assert "seat driver is not in the file: its back was not picked" in after["words"]
    assert after["next"][0].startswith("workbench new ") and after["warnings"] == []
    seat = asked(page, "face", seat="driver", surface="back", **BACK)["seats"][0]
    assert seat["moves"] == ["pan", "rest"] and seat["tilt"] == [0, 0]
    assert asked(page, "carry", seat="driver", parts=["pan"])["seats"][0]["moves"] == ["pan"]
    tilted = asked(page, "figure", kind="seat", name="driver", figure="tilt", value=[-3, 6])
    assert tilted["seats"][0]["tilt"] == [-3, 6]


@pytest.mark.parametrize(
    ("verb", "given", "words"),
    [
        ("face", {"seat": "driver", "surface": "cushion"}, "nothing was picked"),
        ("face", {"seat": "driver", "surface": "roof"}, "expected cushion or back"),
        (
            "face",
            {"seat": "driver", "surface": "back", **BACK, "far": "near"},
            "a number of metres",
        ),
        ("mesh", {"row": 0, "up": "w"}, "up: expected an axis"),
        ("mesh", {"row": 0.5, "up": "z"}, "row: expected the number of a mesh"),
        ("join", {"parts": ["pan"], "to": "rest"}, "there is a part 'rest' already"),
        ("sit", {"on": True}, "there is no seat yet"),
        ("eye", {"seat": "driver"}, "there is no seat 'driver' yet"),
        ("save", {"to": "../out.yaml"}, "a name such as environment_2.yaml is needed"),
        ("save", {"to": "run.sh"}, "a name such as environment_2.yaml is needed"),
        ("joint", {}, "nothing is called 'joint'"),
        (
            "figure",
            {"kind": "seat", "name": "x", "figure": "srp", "value": {}},
            "expected a number",
        ),
    ],
)
def test_what_cannot_be_done_is_a_fault_and_changes_nothing(bench, verb, given, words):
    _, page, desk = bench
    before = desk.live
    page.send_text(json.dumps({"n": 7, "do": verb, **given}))
    head, _ = frames_until(page, "fault")
    assert words in head["words"] and desk.live is before


def test_a_foreign_file_is_asked_about_and_read_only_saves_nothing(bench, mesh):
    _, page, _ = bench
    (mesh.parent / "environment.yaml").write_text("mine\n")
    fault = asked(page, "save")
    assert fault["kind"] == "fault" and fault["ask"] == "over"
    assert asked(page, "save", to="cab.yaml")["file"] == "cab.yaml"
    with client_of(DescribeDesk(str(mesh), read_only=True)) as client:
        entered(client)
        with page_of(client) as other:
            assert "read only" in asked(other, "save")["words"]
    assert (mesh.parent / "environment.yaml").read_text() == "mine\n"


def test_a_person_is_seated_and_gives_the_eye_point(bench):
    client, page, _ = bench
    asked(page, "face", seat="driver", surface="cushion", **CUSHION)
    asked(page, "face", seat="driver", surface="back", **BACK)
    assert asked(page, "sit", on=True)["sitting"]
    assert len(client.get("/scene").text) > 6_000
    low = asked(page, "figure", kind="seat", name="driver", figure="srp", value=[0.1, 0.2, 0.05])
    assert any("floor" in words for words in low["seated"]["driver"]["doubts"])
    asked(page, "undo")
    (eye,) = asked(page, "eye", seat="driver")["points"]
    x, y, z = eye["at"]
    assert eye["name"] == "driver_design_eye" and y == pytest.approx(SRP[1], abs=0.01)
    assert SRP[0] - 0.3 < x < SRP[0] + 0.2 and SRP[2] + 0.6 < z < SRP[2] + 0.9


def test_a_file_is_added_moved_undone_and_another_one_added_in_its_place(bench, mesh):
    client, page, _ = bench
    knob = {"knob": corners((0, 0, 0), (0.02, 0.02, 0.02))}
    (mesh.parent / "panel.obj").write_text(obj_text(knob))
    (mesh.parent / "wheel.obj").write_text(obj_text({"wheel": corners((0, 0, 0), (0.3, 0.3, 0.1))}))
    assert asked(page, "agree")["others"] == ["panel.obj", "wheel.obj"]
    added = asked(page, "add", file="panel.obj")
    assert [row["file"] for row in added["meshes"]] == ["cab.obj", "panel.obj"]
    assert added["others"] == ["wheel.obj"]
    moved = asked(page, "move", row=1, to=[0.5, 0, 0.2])
    assert moved["parts"][-1]["at"] == [0.51, 0.01, 0.21]
    for _ in range(2):
        back = asked(page, "undo")
    assert [part["name"] for part in back["parts"]] == ["pan", "rest", "floor", "lever"]
    assert client.get("/scene").status_code == 200
    other = asked(page, "add", file="wheel.obj")
    assert [part["name"] for part in other["parts"]][-1] == "wheel" and not other["redo"]
    assert "no such file" in asked(page, "add", file="gone.obj")["words"]
    assert asked(page, "save")["kind"] == "saved"
    assert load_environment(mesh.parent / "environment.yaml").parts[-1] == "wheel"


def test_several_files_are_opened_at_once(mesh):
    (mesh.parent / "panel.obj").write_text(obj_text({"knob": corners((0, 0, 0), (0.1, 0.1, 0.1))}))
    desk = DescribeDesk(str(mesh), str(mesh.parent / "panel.obj"))
    assert [row["file"] for row in desk.live.says["meshes"]] == ["cab.obj", "panel.obj"]
    assert not desk.history.can_undo


def test_several_files_are_of_meshes_alone(mesh, capsys):
    assert main(["live", "trainer_clearance", str(mesh)]) == 2
    assert "a study is opened alone" in capsys.readouterr().err


def test_a_doubt_is_put_away_and_comes_back_with_undo(bench):
    _, page, _ = bench
    (doubt,) = asked(page, "mesh", row=0, length="mm")["sizes"]
    away = asked(page, "accept", about=doubt["about"])
    assert doubt not in away["sizes"] and doubt in asked(page, "undo")["sizes"]


def test_a_first_study_is_made_of_what_was_saved_and_opened_in_its_place(bench, mesh):
    client, page, _ = bench
    assert "save the environment first" in asked(page, "study")["words"]
    asked(page, "face", seat="driver", surface="cushion", **CUSHION)
    asked(page, "face", seat="driver", surface="back", **BACK)
    asked(page, "save")
    asked(page, "agree")
    assert "save the environment first" in asked(page, "study")["words"]
    asked(page, "save")
    page.send_text(json.dumps({"n": 7, "do": "study"}))
    frames_until(page, "moved")
    assert (mesh.parent / "study.yaml").is_file()
    assert 'src="/page/app.js"' in client.get("/").text
    with page_of(client) as other:
        head, _ = frames_until(other, "hello")
        assert [one["role"] for one in head["people"]] == ["driver"]


def test_what_is_not_saved_at_the_end_is_kept_in_a_file_of_its_own(mesh):
    desk = DescribeDesk(str(mesh))
    said = []

    def end():
        app = live_application(
            desk, port=PORT, token=TOKEN, runner=run_and_write, ended=said.append
        )
        with TestClient(app, base_url=f"http://{HOST}"):
            pass
        return said[-1]

    assert end() == ""  # a mesh that was only looked at
    desk.do(Question(1, "leave", {"parts": ["lever"]}))
    kept = mesh.parent / "environment_unsaved.yaml"
    assert end().startswith(f"what was not saved is in {kept}")
    assert load_environment(kept).parts == ("pan", "rest", "floor")
    assert "environment_unsaved_2.yaml" in end()
    desk.do(Question(2, "save", {"to": "", "over": False}))
    assert end() == ""


def test_a_question_that_was_done_already_is_not_done_again(bench):
    client, page, desk = bench
    lever = {"part": "lever", "start": [0.62, 0.02, 2], "way": [0, 0, -1]}
    asked(page, "place", kind="control", **lever)
    with page_of(client) as again:
        frames_until(again, "description")
        question = {"n": 7, "do": "place", "kind": "control", **lever, "again": True}
        again.send_text(json.dumps(question))
        assert frames_until(again, "known")[0]["answers"] == 7
        again.send_text(json.dumps({**question, "n": 8}))
        assert len(frames_until(again, "description")[0]["controls"]) == 2
    assert list(desk.live.says["controls"]) == ["lever", "lever_2"]


# --- in a browser -----------------------------------------------------------------------------------

PIXEL = """async ([view, point]) => {
  const { Camera, VIEWS } = await import("/view/camera.js");
  const stage = document.querySelector("#picture .stage");
  const canvas = stage.querySelector("canvas");
  const camera = new Camera();
  camera.aspect = canvas.clientWidth / canvas.clientHeight;
  camera.look(...VIEWS[view]);
  camera.fit(JSON.parse(stage.dataset.box));
  const [u, v] = camera.project(point);
  const box = canvas.getBoundingClientRect();
  return [box.left + (0.5 + 0.5 * u) * box.width, box.top + (0.5 - 0.5 * v) * box.height];
}"""


def clicked(page, view, point, words):
    page.get_by_role("button", name=view, exact=True).click()
    page.wait_for_timeout(200)
    page.mouse.click(*page.evaluate(PIXEL, [view, point]))
    page.wait_for_function("words => document.getElementById('status').textContent.includes(words)", arg=words)  # fmt: skip


@pytest.fixture(scope="module")
def browser():
    playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    if CHROMIUM is None:
        pytest.skip("there is no Chromium: apt install chromium")
    with playwright.sync_playwright() as running, launched(running) as found:
        yield found


@contextlib.contextmanager
def shown(browser, mesh, before=""):
    """The page of a mesh whose picture is there; `faults` is a list on it."""
    with served(mesh, before) as address:
        page = browser.new_page(viewport={"width": 1200, "height": 700})
        page.faults = []
        page.set_default_timeout(60_000)
        page.on("pageerror", lambda error: page.faults.append(str(error)))
        page.goto(address, wait_until="commit")
        page.wait_for_selector("#picture .stage[data-box]", state="attached")
        yield page
        page.close()


def says(page, words):
    page.wait_for_function("words => document.getElementById('status').textContent.includes(words)", arg=words)  # fmt: skip


def placed_lever(page):
    """A control where the lever is clicked from above."""
    page.get_by_label("control", exact=True).check()
    clicked(page, "top", [0.62, 0.02, 0.6], "is on lever")


def test_a_cushion_and_a_back_are_clicked_and_the_file_says_so(browser, mesh):
    with shown(browser, mesh) as page:
        page.get_by_label("cushion", exact=True).check()
        clicked(page, "top", [SRP[0] + 0.25, SRP[1], SRP[2] + 0.05], "now pick the back")
        clicked(page, "front", [SRP[0] - 0.1, SRP[1], SRP[2] + 0.35], "figures are those")
        page.get_by_label("choose lever").check()
        page.locator("#part-name").fill("gear")
        page.locator("#part-name").press("Enter")
        page.get_by_label("choose gear").wait_for()
        assert page.get_by_label("choose gear").is_checked()  # so that more can be said of it
        page.get_by_label("driver: yaw").fill("1")
        page.keyboard.press("Tab")
        page.wait_for_function("() => document.querySelector('.seat').textContent.includes('typed')")  # fmt: skip
        page.keyboard.press("Control+s")
        says(page, "saved environment.yaml")
        assert "workbench new" in page.locator("#next").inner_text() and page.faults == []
    text = (mesh.parent / "environment.yaml").read_text()
    assert "srp: [100, 200, 300]  # fitted" in text and "yaw: 1  # typed" in text


def test_what_is_being_typed_is_saved_and_no_answer_writes_over_it(browser, mesh):
    with shown(browser, mesh) as page:
        placed_lever(page)
        field = page.get_by_label("lever: at 1")
        field.focus()
        page.keyboard.press("Control+a")
        page.keyboard.type("650")
        page.evaluate("async () => (await import('/page/connection.js')).ask('agree')")
        says(page, "unit and axes are right")
        assert field.input_value() == "650"
        page.keyboard.press("Control+s")
        says(page, "saved environment.yaml")
        assert page.faults == []
    assert load_environment(mesh.parent / "environment.yaml").controls[0].at[0] == 0.65


def test_what_is_refused_stays_in_its_field_until_escape(browser, mesh):
    with shown(browser, mesh) as page:
        placed_lever(page)
        name = page.get_by_label("name of the control lever")
        name.fill("x" * 90)
        page.keyboard.press("Tab")
        says(page, "a control needs a name")
        assert name.input_value() == "x" * 90 and name.get_attribute("aria-invalid") == "true"
        name.press("Escape")
        assert name.input_value() == "lever"
        page.locator("#control-name").fill("gear")
        page.locator("#picture canvas").click(position={"x": 5, "y": 5})
        says(page, "nothing was picked")
        assert page.locator("#control-name").input_value() == "gear"
        assert page.faults == []


SLOW = """
import time
from workbench.live.describe_desk import DescribeDesk
agree = DescribeDesk._edited
def slowly(self, question):
    time.sleep(1.0 if question.verb == "agree" else 0.0)
    return agree(self, question)
DescribeDesk._edited = slowly
"""


def test_save_waits_for_what_is_computed_and_leaving_asks_until_then(browser, mesh):
    with shown(browser, mesh, SLOW) as page:
        page.get_by_role("button", name="They are right").click()
        asks = []
        page.on("dialog", lambda dialog: (asks.append(dialog.type), dialog.dismiss()))
        page.evaluate("() => location.reload()")
        page.wait_for_timeout(100)
        assert asks == ["beforeunload"]
        page.get_by_role("button", name="Save", exact=True).click()
        says(page, "saved environment.yaml")
        page.reload()
        page.wait_for_selector("#picture .stage[data-box]", state="attached")
        assert asks == ["beforeunload"] and page.faults == []
    assert "length: m  # chosen" in (mesh.parent / "environment.yaml").read_text()


def test_a_click_is_not_lost_with_the_connection(browser, mesh):
    with shown(browser, mesh) as page:
        page.evaluate(
            """async () => {
              const send = WebSocket.prototype.send;
              WebSocket.prototype.send = function () {
                WebSocket.prototype.send = send;
                this.close();
              };
              const { ask } = await import("/page/connection.js");
              ask("leave", { parts: ["lever"] }, true);
              ask("leave", { parts: ["floor"] }, true);
            }"""
        )
        page.wait_for_function("() => document.querySelectorAll('#parts tr').length === 2")
        assert page.locator("#left").inner_text().count("put back") == 2
        assert page.faults == []


def frame_height(page):
    """The share of the picture's height that the frame around what is chosen takes."""
    picture = np.asarray(pixels(page, "#picture canvas")).astype(int)
    orange = (np.abs(picture - [226, 120, 0]).sum(axis=2) < 60).any(axis=1)
    rows = np.flatnonzero(orange)
    return np.ptp(rows) / len(picture)


def test_a_small_part_is_found_and_fit_leaves_the_standing_person_out(browser, mesh):
    mesh.write_text(obj_text(seat_parts() | {"knob": corners((0.5, 0.1, 0.3), (0.52, 0.12, 0.32))}))
    with shown(browser, mesh) as page:
        page.get_by_label("choose knob").check()
        assert frame_height(page) < 0.05
        page.locator("#picture canvas").press("f")
        assert 0.2 < frame_height(page) < 1.0
        page.get_by_role("button", name="corner", exact=True).click()
        assert frame_height(page) < 0.05
        page.locator("#part-none").click()
        assert page.locator("#parts input[aria-label^=show]:checked").count() == 0
        page.get_by_role("button", name="fit", exact=True).click()
        assert 0.2 < frame_height(page) < 1.0
        assert page.faults == []


def test_a_section_is_through_the_mesh_or_what_is_looked_at_not_through_the_man(browser, mesh):
    mesh.write_text(obj_text(seat_parts() | {"knob": corners((0.5, 0.1, 0.3), (0.52, 0.12, 0.32))}))
    with shown(browser, mesh) as page:
        section = page.get_by_role("button", name="section", exact=True)
        for view, words in (("left", "cut at y 150 mm"), ("front", "cut at x 300 mm")):
            page.get_by_role("button", name=view, exact=True).click()
            section.click()
            assert section.get_attribute("title") == words
            section.click()
        page.get_by_label("choose knob").check()
        page.get_by_role("button", name="fit", exact=True).click()
        page.get_by_role("button", name="section", exact=True).click()
        assert section.get_attribute("title") == "cut at x 510 mm"
        assert page.faults == []


def test_from_a_mesh_to_the_share_of_people_by_clicks_alone(browser, mesh, monkeypatch):
    monkeypatch.chdir(mesh.parent)
    with shown(browser, mesh) as page:
        page.get_by_role("button", name="They are right").click()
        page.get_by_label("cushion", exact=True).check()
        clicked(page, "top", [SRP[0] + 0.25, SRP[1], SRP[2] + 0.05], "now pick the back")
        clicked(page, "front", [SRP[0] - 0.1, SRP[1], SRP[2] + 0.35], "figures are those")
        page.get_by_role("button", name="Save", exact=True).click()
        page.get_by_role("button", name="Make a first study and open it").click()
        page.wait_for_function("() => document.getElementById('person')?.value === 'driver'")
        page.get_by_label("how many").fill("3")
        with page.expect_popup() as opened:
            page.get_by_role("button", name="Ask 3 people").click()
        report = opened.value
        report.wait_for_selector("main .lead")
        said = report.locator("main .lead").inner_text().replace("\xa0", " ")
        assert said.startswith("Nobody fits (95 % interval 0 to 56 %, 3 people).")
        assert page.locator("#report-headline").inner_text() == said
        report.wait_for_selector(".turn canvas", state="attached")
        assert page.faults == []
    assert (mesh.parent / "study.yaml").is_file()
