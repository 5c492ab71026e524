"""Changes of one value in a YAML text, at the marks of the parser: all other bytes stay.

A value that is shared by an anchor is changed for all who share it or for one place alone; whoever
asks for the change says which.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Literal

from workbench.errors import InputError
from workbench.files.schema import metres_in
from workbench.files.yaml_marks import Item, Node, marked, walked

__all__ = [
    "Found",
    "Key",
    "SharedValueError",
    "Sharing",
    "column_of",
    "exchanged",
    "flow_text",
    "length_text",
    "mapping_at",
    "new_line",
    "node_at",
    "node_text",
    "own_copy",
    "plain_name",
    "unit_of",
    "with_entry",
    "with_row",
    "without_entry",
]

Sharing = Literal["ask", "all", "one"]
"""What becomes of a value that several places share: it is asked about, changed in all of them, or
in one alone."""
Key = tuple[str | int, ...]
MOST_SHARED = 20
"""Anchors within anchors that are resolved for one change."""


class SharedValueError(InputError):
    """A value that is to be changed is shared with other places, and nobody said what becomes of
    these."""


@dataclass(frozen=True)
class Found:
    """The node at a key, and the nodes on the way to it that other places share."""

    node: Node | None
    shared: tuple[Node, ...]


def own_copy(text: str, key: Key, sharing: Sharing) -> str:
    """The text with nothing shared on the way to a key, where one place alone is to change."""
    for _ in range(MOST_SHARED):
        shared = node_at(text, key).shared
        if not shared or sharing == "all":
            return text
        if sharing == "ask":
            raise SharedValueError(_shared_words(text, key, shared[0]))
        text = _unshared(text, shared[0])
    raise InputError(f"{_name(key)}: anchors within anchors too deep to change one place alone")


def _shared_words(text: str, key: Key, node: Node) -> str:
    """That a value is shared, and where its anchor is."""
    every = [one for one in walked(marked(text)) if one.anchor == node.anchor]
    line = text.count("\n", 0, every[0].start) + 1
    return (
        f"{_name(key)} is shared by {len(every)} places (&{node.anchor} in line {line}): "
        "change all of them, or this one only?"
    )


def _name(key: Key) -> str:
    return " ".join(str(part + 1) if isinstance(part, int) else part for part in key)


def node_at(text: str, key: Key) -> Found:
    """The node at a key; aliases on the way are followed, and the shared nodes noted."""
    root = marked(text)
    anchors: dict[str, Node] = {}
    uses: dict[str, int] = {}
    for node in walked(root):
        if node.anchor:
            uses[node.anchor] = uses.get(node.anchor, 0) + 1
        if node.anchor and node.kind != "alias":
            anchors[node.anchor] = node
    shared: list[Node] = []
    here: Node | None = root
    for part in (None, *key):
        if part is not None and here is not None:
            here = _child(here, part)
        if here is None:
            break
        if here.anchor and uses[here.anchor] > 1:
            shared.append(here)
        if here.kind == "alias":
            here = anchors[here.anchor]
    return Found(here, tuple(shared))


def node_text(text: str, key: Key) -> str | None:
    """The words of the scalar at a key; None where there is none."""
    node = node_at(text, key).node
    return node.text if node is not None and node.kind == "scalar" else None


def _child(node: Node, part: str | int) -> Node | None:
    """The value of a mapping at a key, or of a sequence at a number."""
    if isinstance(part, int):
        rows = node.items if node.kind == "sequence" else []
        return rows[part].value if part < len(rows) else None
    item = node.item(part) if node.kind == "mapping" else None
    return None if item is None else item.value


def _unshared(text: str, node: Node) -> str:
    """The text with one place of a shared value written out; the anchor goes to the next place."""
    every = [one for one in walked(marked(text)) if one.anchor == node.anchor]
    anchored = next(one for one in every if one.kind != "alias")
    plain = flow_text(text, anchored)
    if node.kind == "alias":
        return text[: node.start] + plain + text[node.end :]
    after = next(one for one in every if one.start > anchored.start)
    first = anchored.start
    begin = first + len(f"&{node.anchor}")
    while text[begin].isspace() and anchored.flow | (anchored.kind == "scalar"):
        begin += 1
    moved = f"&{node.anchor} {plain}"
    return text[:first] + text[begin : after.start] + moved + text[after.end :]


def flow_text(text: str, node: Node) -> str:
    """A value in flow style, without anchors of its own."""
    if node.kind == "alias":
        return f"*{node.anchor}"
    if node.kind == "mapping":
        rows = [
            f"{flow_text(text, item.key)}: {flow_text(text, item.value)}"
            for item in node.items
            if item.key is not None
        ]
        return "{" + ", ".join(rows) + "}"
    if node.kind == "sequence":
        return "[" + ", ".join(flow_text(text, item.value) for item in node.items) + "]"
    raw = text[node.start : node.end].strip()
    if node.anchor:
        raw = raw.removeprefix(f"&{node.anchor}").strip()
    quoted = raw[:1] in ("'", '"')
    safe = quoted or (not set(raw) & set(",[]{}\n#") and raw[:1] not in ("|", ">"))
    return raw if safe and raw else json.dumps(node.text, ensure_ascii=False)


def mapping_at(text: str, key: Key) -> Node:
    """The mapping at a key."""
    node = node_at(text, key).node
    if node is None or node.kind != "mapping":
        raise InputError(f"{_name(key)}: no mapping stands there to be changed")
    return node


def with_row(text: str, sequence: Node | None, row: str) -> str:
    """The text with one entry more at the end of a sequence that has some, in its own style."""
    assert sequence is not None and sequence.items
    last = sequence.items[-1].value
    if sequence.flow:
        return f"{text[: last.end]}, {row}{text[last.end :]}"
    dash = text.rfind("-", 0, sequence.items[0].value.start)
    line = text.find("\n", last.end)
    line = len(text) if line < 0 else line
    if text[line - 1 : line] == "\r":
        line -= 1
    return f"{text[:line]}{new_line(text)}{' ' * column_of(text, dash)}- {row}{text[line:]}"


def plain_name(name: str) -> str:
    """A name as it may stand in flow style."""
    safe = name.replace("_", "").isalnum() and not name[0].isdigit()
    return name if safe else json.dumps(name, ensure_ascii=False)


def exchanged(text: str, node: Node, value: str) -> str:
    """The text with another value in the place of a node; its anchor stays."""
    anchor = f"&{node.anchor} " if node.anchor and node.kind != "alias" else ""
    return text[: node.start] + anchor + value + text[node.end :]


def with_entry(text: str, mapping: Node, key: str, value: str, after: Item | None = None) -> str:
    """The text with one entry more in a mapping, behind one of its entries or the last, in the
    mapping's own style."""
    if not mapping.items:
        brace = text.index("{", mapping.start)
        return f"{text[: brace + 1]}{key}: {value}{text[brace + 1 :]}"
    item = after or mapping.items[-1]
    end = item.value.end
    if mapping.flow:
        return f"{text[:end]}, {key}: {value}{text[end:]}"
    first = mapping.items[0].key
    assert first is not None
    line = text.find("\n", end)
    line = len(text) if line < 0 else line
    if text[line - 1 : line] == "\r":
        line -= 1
    entry = f"{new_line(text)}{' ' * column_of(text, first.start)}{key}: {value}"
    return text[:line] + entry + text[line:]


def column_of(text: str, at: int) -> int:
    """How many characters stand before one in its line."""
    return at - (text.rfind("\n", 0, at) + 1)


def new_line(text: str) -> str:
    """How the lines of a text end."""
    return "\r\n" if "\r\n" in text else "\n"


def without_entry(text: str, mapping: Node, key: str) -> str:
    """The text without an entry of a mapping; null in its place where a comment or the mapping's own
    style would go with it."""
    row = next(k for k, item in enumerate(mapping.items) if item.name == key)
    item = mapping.items[row]
    assert item.key is not None
    begin, end = item.key.start, item.value.end
    if len(mapping.items) > 1 and mapping.flow:
        if row:
            begin = mapping.items[row - 1].value.end
        else:
            later = mapping.items[1].key
            assert later is not None
            end = later.start
    elif len(mapping.items) > 1 and row:
        begin = text.rfind("\n", 0, begin)
        begin -= text[begin - 1 : begin] == "\r"
        tail = text.find("\n", end)
        tail = len(text) if tail < 0 else tail
        if "#" not in text[end:tail]:
            end = tail - (text[tail - 1 : tail] == "\r")
    elif not mapping.flow:
        return exchanged(text, item.value, "null")
    if "#" in text[begin : item.key.start] + text[item.value.end : end]:
        return exchanged(text, item.value, "null")
    return text[:begin] + text[end:]


def unit_of(text: str) -> float:
    """The unit of length of a study [m]."""
    unit = node_at(text, ("length",)).node
    return metres_in[unit.text] if unit is not None else 1.0


def length_text(value: float) -> str:
    """A length as it stands in a file: to 1e-7 of the unit, without zeros at its end."""
    return f"{round(value, 7) + 0.0:.10g}"
