"""A turnable picture as a piece of a page: the place with its still picture, script, style, data.

Everything is inline: a page with it is one file, asks for nothing and works from a disk. The
modules of the script are joined into one, in the order in which they import each other, so that a
content security policy can name it by its hash.
"""

from __future__ import annotations

import base64
import hashlib
import io
import re
from functools import cache
from html import escape
from importlib.resources import files

from PIL import Image

from workbench.draw.web.packing import Packing
from workbench.draw.web.views import WebView

__all__ = [
    "MODULES",
    "PAGE",
    "STILL",
    "WIDGET",
    "pair_html",
    "picture_address",
    "place_html",
    "policy",
    "script",
    "scripts_html",
    "standalone",
    "style",
]

MODULES = (
    "camera",
    "pick",
    "shaders",
    "wire",
    "programs",
    "list",
    "wipe",
    "over",
    "card",
    "painting",
    "viewer",
    "labels",
    "help",
    "film",
    "touch",
    "panel",
)
"""The modules of a picture, each after those that it imports."""
PAGE = (*MODULES, "page")
"""The modules of a page."""
WIDGET = (*MODULES, "naming", "widget")
"""The modules of a widget of a notebook."""
_FRAME = 520
"""Height of an inline frame [pixels]."""
STILL = 520
"""Width and height of a still picture [pixels]."""
COLOURS = 160
"""Colours of a still picture."""
_COVERAGE = 1
"""Of choosing the colours of a picture: that which covers all, so that marks keep theirs."""
_IMPORT = re.compile(r"^import .*?;\n", re.MULTILINE | re.DOTALL)
_COMMENT = re.compile(r"^\s*// .*\n", re.MULTILINE)
_PAGE_STYLE = """:root { --ink: #1d2733; --soft: #5c6b7a; --line: #d9dfe5; --paper: #fff; --wash: #f5f7f9; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #dfe5ea; --soft: #9aa7b3; --line: #34404b; --paper: #171d23; --wash: #1f272f; }
}
body { margin: 0; font: 15px/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif;
       color: var(--ink); background: var(--paper); }
.turn { margin: 0; }
.turn canvas { height: calc(100vh - 72px); min-height: 200px; }
"""


def picture_address(image: Image.Image, *, colours: int = COLOURS) -> str:
    """Return a picture as an address that holds it, a PNG of few colours."""
    out = io.BytesIO()
    image.quantize(colours, method=_COVERAGE).save(out, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(out.getvalue()).decode("ascii")


@cache
def script(modules: tuple[str, ...] = PAGE) -> str:
    """Return the script of a page, or of a `WIDGET`, as one module without comments."""
    folder = files("workbench.draw.web")
    joined = []
    for name in modules:
        text = (folder / f"{name}.js").read_text(encoding="utf-8")
        text = _COMMENT.sub("", _IMPORT.sub("", text))
        joined.append(re.sub(r"^export (?!default)", "", text, flags=re.MULTILINE).strip())
    return "\n".join(joined) + "\n"


@cache
def style() -> str:
    """Return the style sheet of the pictures; it uses the colours of the page by their names."""
    return (files("workbench.draw.web") / "view.css").read_text(encoding="utf-8")


def policy(*scripts: str, media: bool = False) -> str:
    """Return the content security policy of a page with this script and those given, and no other.

    Parameters
    ----------
    scripts
        Other scripts of the page, each as it stands between its tags.
    media
        Whether the page shows a film that lies beside it.
    """
    hashes = " ".join(f"'sha256-{_digest(text)}'" for text in (script(), *scripts))
    beside = " 'self' file:" if media else ""
    rules = [
        "default-src 'none'",
        f"script-src {hashes}",
        "style-src 'unsafe-inline'",
        f"img-src data:{beside}",
        *(["media-src 'self' file:"] if media else []),
        "base-uri 'none'",
        "form-action 'none'",
    ]
    return "; ".join(rules)


def _digest(text: str) -> str:
    """The hash of a script as a policy names it."""
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")


def scripts_html(packing: Packing) -> str:
    """Return the data and the script that stand at the end of a page; "" without views."""
    if not packing.views:
        return ""
    return (
        f'<script type="text/plain" id="views-data">{packing.text()}</script>\n'
        f'<script type="module">{script()}</script>\n'
    )


def place_html(index: int, *, still: str, alt: str, caption: str = "") -> str:
    """Return the place of a turnable picture.

    Parameters
    ----------
    index
        Of the view in the page's packing.
    still
        Address of the still picture, shown until the view is there and where it cannot be; "" for
        none.
    alt
        The still picture in words.
    caption
        What stands below it.
    """
    picture = f'<img class="still" src="{escape(still)}" width="{STILL}" height="{STILL}" alt="{escape(alt)}">'
    if not still:
        picture = f'<p class="still">{escape(alt)}</p>'
    return (
        f'<div class="turn" id="view-{index}" data-view="{index}">{picture}'
        f'<p class="said">{escape(caption)}</p></div>'
    )


def pair_html(
    index: int, *, stills: tuple[str, str], names: tuple[str, str], alt: str, caption: str
) -> str:
    """Return the place of a picture of two states; the still pictures stand side by side.

    Parameters
    ----------
    index
        Of the view in the page's packing.
    stills
        Addresses of the still pictures of the two states.
    names
        What the states are called.
    alt
        What both pictures show.
    caption
        What stands below them.
    """
    pictures = "".join(
        f'<figure><img src="{escape(still)}" width="{STILL}" height="{STILL}" alt="{escape(f"{name}: {alt}")}">'
        f"<figcaption>{escape(name)}: {escape(alt)}</figcaption></figure>"
        for still, name in zip(stills, names, strict=True)
    )
    return (
        f'<div class="turn" id="view-{index}" data-view="{index}"><div class="still pair">{pictures}</div>'
        f'<p class="said">{escape(caption)}</p></div>'
    )


def standalone(*views: WebView, still: str = "", caption: str = "") -> str:
    """Return a whole page with turnable pictures, the same bytes for the same views.

    Parameters
    ----------
    views
        What is shown, one below the other.
    still, caption
        As of `place_html`, of the first one.
    """
    packing = Packing()
    first = place_html(packing.add(views[0]), still=still, alt=views[0].title, caption=caption)
    others = [
        place_html(packing.add(view), still="", alt=view.title, caption=view.title)
        for view in views[1:]
    ]
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{escape(policy())}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(views[0].title)}</title><style>{_PAGE_STYLE}{style()}</style></head>"
        f"<body>{first}{''.join(others)}\n{scripts_html(packing)}</body></html>\n"
    )


def frame_html(*views: WebView) -> str:
    """Return turnable pictures as an inline frame, for a notebook: what runs in it can reach
    nothing outside of it.

    Parameters
    ----------
    views
        What is shown, one below the other.
    """
    page = standalone(*views, caption=views[0].title)
    title = escape(views[0].title)
    return (
        f'<iframe sandbox="allow-scripts" title="{title}" width="100%" height="{_FRAME}"'
        f' style="border: 0" srcdoc="{escape(page)}"></iframe>'
    )
