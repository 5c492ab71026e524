"""The widget of a notebook: its state in Python, with anywidget, and its script in a browser, without."""

from __future__ import annotations

import base64
import json
import re
import sys

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from tests.web_page import launched, opened, pixels, started
from workbench.draw.web.packing import Packing
from workbench.draw.web.snippet import WIDGET, script, style
from workbench.draw.web.views import WebView, body_view

PAGE = (ROOT / "docs" / "notebooks.md").read_text()
PICTURE = "#a canvas"
STATE = {
    "picture": 0,
    "look_from": "left",
    "section": None,
    "hidden": [],
    "see_through_walls": True,
    "selected": [],
    "height": 300,
}
HOST = """<!doctype html><meta charset="utf-8"><style>%s</style>
<body style="background: oklch(1 0 0)"><div id="a"></div><div id="b"></div>
<script type="module">
const { state, source } = %s;
const bytes = (text) => new DataView(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
class Model {
  constructor() {
    this.state = { ...state, _scene: bytes(state._scene), _people: bytes(state._people) };
    this.heard = [];
    this.told = [];
  }
  get(name) { return this.state[name]; }
  set(name, value) {
    this.told.push(name);
    this.put(name, value);
  }
  put(name, value) {
    if (JSON.stringify(value) === JSON.stringify(this.state[name]) && !value?.byteLength) return;
    this.state[name] = value;
    for (const [event, act] of [...this.heard]) if (event === `change:${name}`) act();
  }
  on(event, act) { this.heard.push([event, act]); }
  off(event, act) { this.heard = this.heard.filter(([one, other]) => one !== event || other !== act); }
  save_changes() {}
}
const address = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
const { default: widget } = await import(address);
window.model = new Model();
window.bytes = bytes;
window.show = (id) => widget.render({ model, el: document.getElementById(id) });
window.end = show("a");
</script>"""
"""A page that does what a notebook does with the script of a widget; `put` is Python's side."""


@pytest.fixture(scope="module")
def arms(one_arm):
    """An arm that hangs down, and the same with the elbow at a right angle."""
    return [wb.place(one_arm, wb.pose(one_arm, {"ELBOW": {"flexion": angle}})) for angle in (0, 90)]


def packed(*views):
    packing = Packing()
    for view in views:
        packing.add(view)
    return packing.block()


def people_block(placed, *names):
    """What Python sends for people of these names."""
    return packed(WebView("", tuple(body_view(placed, name, "warm") for name in names)))


# --- in a browser, with a model that is made up ---


@pytest.fixture(scope="module")
def chromium():
    with started() as playwright, launched(playwright) as running:
        yield running


@pytest.fixture
def page(chromium, arms, box_cab, tmp_path):
    """A page with the widget of a cab in which an arm hangs down."""
    state = STATE | {
        "_scene": base64.b64encode(packed(WebView("a cab", environment=box_cab))).decode(),
        "_people": base64.b64encode(people_block(arms[0], "anna")).decode(),
    }
    given = json.dumps({"state": state, "source": script(WIDGET)}).replace("<", "\\u003c")
    (tmp_path / "host.html").write_text(HOST % (style(), given))
    with opened(chromium, tmp_path / "host.html") as page:
        page.locator(PICTURE).wait_for()
        page.wait_for_function("model.heard.length > 0")
        yield page
        assert page.faults == []
        assert [url for url in page.requests if not url.startswith(("file:", "blob:"))] == []


def put(page, name, value):
    """Set something as Python does."""
    if isinstance(value, bytes):
        text = base64.b64encode(value).decode()
        page.evaluate("([name, text]) => model.put(name, bytes(text))", [name, text])
    else:
        page.evaluate("([name, value]) => model.put(name, value)", [name, value])


def skin(image):
    """(columns, rows) that the warm colour of a body covers, from first to last."""
    r, g, b = np.moveaxis(np.asarray(image).astype(int), 2, 0)
    rows, columns = np.nonzero((r > g + 20) & (g > b + 5))
    assert len(rows)
    return np.ptp(columns), np.ptp(rows)


def test_people_are_replaced_in_the_same_picture(page, arms):
    page.evaluate("window.kept = document.querySelector('#a canvas')")
    put(page, "selected", ["anna", "hand"])
    wide, high = skin(pixels(page, PICTURE))
    ring = page.locator("#a .ring").bounding_box()
    put(page, "_people", people_block(arms[1], "anna"))
    bent_wide, bent_high = skin(pixels(page, PICTURE))
    assert bent_wide > 1.5 * wide and bent_high < 0.9 * high
    assert page.evaluate("kept.isConnected")
    assert page.locator("#a .ring").bounding_box()["y"] < ring["y"] - 20  # it goes with the hand
    put(page, "_people", people_block(arms[0], "anna", "bert"))
    page.wait_for_function("!kept.isConnected")
    put(page, "hidden", ["anna", "bert"])
    page.get_by_role("button", name="parts").click()
    boxes = page.locator("#a .list label")
    assert boxes.all_inner_texts()[:2] == [" anna", " bert"]
    assert not boxes.locator("input").first.is_checked()


def test_what_is_chosen_and_hidden_by_hand_comes_back(page):
    box = page.locator(PICTURE).bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.wait_for_function("model.get('selected').length > 1")
    assert page.evaluate("model.get('selected')")[0] == "anna"
    page.keyboard.press("h")
    page.wait_for_function("model.get('hidden').length")
    assert page.evaluate("model.get('hidden')") == ["anna"]
    page.keyboard.press("ArrowLeft")
    page.wait_for_function("model.get('look_from') === ''")
    page.keyboard.press("Escape")
    page.wait_for_function("!model.get('hidden').length && !model.get('selected').length")


def test_python_turns_cuts_and_chooses(page):
    put(page, "look_from", "top")
    put(page, "section", "left")
    page.wait_for_function("model.get('section').startsWith('left=')")
    assert page.get_by_role("button", name="section").get_attribute("aria-pressed") == "true"
    put(page, "section", None)
    put(page, "selected", ["anna", "hand", "thumb tip"])
    assert page.locator("#a .said").inner_text() == "anna: hand, thumb tip"
    put(page, "see_through_walls", False)
    button = page.get_by_role("button", name="see-through walls")
    assert button.get_attribute("aria-pressed") == "false"
    assert page.evaluate("model.told.filter((name) => name !== 'section')") == []


def test_two_places_of_one_widget_share_its_state_and_go_when_they_are_closed(page):
    page.evaluate("void (window.other = show('b'))")
    page.locator("#b canvas").wait_for()
    page.locator("#a").get_by_role("button", name="right").click()
    page.locator("#a").get_by_role("button", name="see-through walls").click()
    wanted = "#b .bar button[aria-pressed=false]:text('see-through walls')"
    page.locator(wanted).wait_for()
    page.evaluate("end()")
    assert page.locator("#a canvas").count() == 0 and page.locator("#b canvas").count() == 1
    page.evaluate("other()")
    assert page.evaluate("model.heard.length") == 0


def test_the_picture_is_dark_before_a_dark_page_and_comes_back_after_the_context_is_lost(
    page, arms
):
    put(page, "hidden", ["floor", "wall", "post"])
    light = np.asarray(pixels(page, PICTURE))[2, 2]
    page.evaluate("document.body.style.background = '#111'")
    dark = np.asarray(pixels(page, PICTURE))
    assert light.min() > 200 and dark[2, 2].max() < 60
    page.evaluate(
        "window.loss = document.querySelector('#a canvas').getContext('webgl2')"
        ".getExtension('WEBGL_lose_context'); loss.loseContext()"
    )
    put(page, "_people", people_block(arms[1], "anna"))
    page.wait_for_timeout(100)
    page.evaluate("loss.restoreContext()")
    assert skin(pixels(page, PICTURE))[0] > 1.5 * skin(dark)[0]


# --- in Python ---


@pytest.fixture
def widget(box_cab, arms):
    pytest.importorskip(
        "anywidget",
        reason="anywidget is not installed: pip install 'bubbleman-workbench[notebook]'",
    )
    return wb.view(box_cab, people={"anna": arms[0]})


def test_people_are_sent_without_the_environment(widget, arms):
    scene = widget._scene
    sent = []
    widget.observe(lambda change: sent.append(change["name"]), ["_scene", "_people", "hidden"])
    widget.people = {"anna": arms[1]}
    assert sent == ["_people"] and widget._scene is scene
    assert widget._people == people_block(arms[1], "anna")
    widget.people = None
    assert widget._people == b""


def test_each_pose_is_a_person_and_a_picture_of_its_own(widget, one_arm):
    poses = wb.join_poses([wb.pose(one_arm, {"ELBOW": {"flexion": a}}) for a in (0, 30, 60)])
    placed = wb.place(one_arm, poses)
    widget.people = placed
    widget.hidden = ["one_arm 3"]
    assert wb.view(placed).titles[2] == "one_arm, pose 3 of 3"


def test_names_that_are_no_longer_there_are_neither_hidden_nor_chosen(widget, arms):
    widget.hidden = ["floor", "anna"]
    widget.selected = ("anna", "hand")
    widget.people = arms[0]
    assert widget.hidden == ("floor",) and widget.selected == ()


def test_what_a_browser_says_is_taken_as_what_python_says(widget):
    widget.set_state({"hidden": ["floor"], "selected": ["anna", "hand"], "section": "left=0.25"})
    assert widget.hidden == ("floor",) and widget.selected == ("anna", "hand")
    assert widget.section == "left=0.25"


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("hidden", ["flor"], "hidden: nothing here is called 'flor'; did you mean 'floor'?"),
        ("hidden", "floor", "hidden: expected a sequence"),
        ("hidden", None, "hidden: expected a sequence"),
        ("look_from", "lefft", "look_from: there is no view 'lefft'; did you mean 'left'?"),
        ("section", "middle", "section: no side or axis 'middle'"),
        ("section", "y=0.2", "section y=0.2: say which side goes: left or right"),
        ("section", "left=here", "section left=here: a place such as left=0.3"),
        ("selected", ["ann", "hand"], "selected: a person was expected, got 'ann'"),
        ("selected", ["anna", "foot"], "selected: a segment of anna was expected, got 'foot'"),
        ("selected", ["anna", "hand", "palm"], "selected: a sphere of hand was expected"),
        ("selected", ["x"], "selected: a part was expected, got 'x'"),
        ("selected", list("abcd"), "got 4 names"),
        ("people", 3, "people: expected a Placed or a mapping"),
        ("people", {"anna": 3}, r"people\['anna'\]: expected a Placed, got 3"),
        ("picture", 1, "picture: there is no picture 1; valid: 0 "),
        ("height", 20, "height: expected 100 to 4000 pixels, got 20"),
        ("see_through_walls", 1, "see_through_walls: expected True or False"),
    ],
)
def test_a_wrong_value_is_refused_in_one_message_and_changes_nothing(widget, name, value, words):
    before = getattr(widget, name)
    with pytest.raises(wb.UsageError, match=words):
        setattr(widget, name, value)
    assert getattr(widget, name) is before


def test_a_section_is_kept_in_metres_and_a_view_without_a_picture_is_refused(widget, one_arm):
    widget.section = "left=300mm"
    assert widget.section == "left=0.3"
    many = wb.place(one_arm, wb.join_poses([wb.pose(one_arm, {})] * 101))
    with pytest.raises(wb.UsageError, match="101 poses; a view takes 100 at most"):
        wb.view(many)
    with pytest.raises(wb.UsageError, match="people: expected 40 poses at most, got 101"):
        widget.people = many


def test_the_code_of_the_page_on_notebooks_runs(widget):
    (block,) = re.findall(r"```python\n(.*?)```", PAGE, re.S)
    made = {}
    exec(compile(block, "notebooks.md", "exec"), made)
    before = made["widget"]._people
    made["slider"].value = 90
    assert made["widget"]._people != before and made["widget"].hidden == (
        "canopy",
        "left_side_wall",
    )


def test_the_page_on_notebooks_names_every_attribute(widget):
    anywidget = pytest.importorskip("anywidget")
    own = set(widget.traits()) - set(anywidget.AnyWidget.class_traits())
    named = {"titles", *(name for name in own if name[0] != "_")}
    assert len(named) == 9
    assert [name for name in named if f"`{name}`" not in PAGE] == []


def test_without_anywidget_a_view_says_what_to_install_and_the_frame_still_shows(
    box_cab, monkeypatch
):
    monkeypatch.setitem(sys.modules, "anywidget", None)
    monkeypatch.delitem(sys.modules, "workbench.draw.web.widget", raising=False)
    with pytest.raises(wb.MissingPartError, match=r"pip install 'bubbleman-workbench\[notebook\]'"):
        wb.view(box_cab)
    assert box_cab._repr_html_().startswith("<iframe")
