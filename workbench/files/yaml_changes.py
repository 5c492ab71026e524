"""A plain value written as YAML, and the changes from one value to another spliced into a text.

Notes say in a comment how a figure was got. They begin with one of `LEADS`: such a comment is the
program's own and is exchanged with its figure. Any other comment stays.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from workbench.files.yaml_edits import (
    Key,
    column_of,
    exchanged,
    mapping_at,
    new_line,
    node_at,
    own_copy,
    with_entry,
)
from workbench.files.yaml_marks import Item, Node

__all__ = ["LEADS", "changed_text", "flow_text", "yaml_text"]

LEADS = ("picked", "fitted", "typed", "assumed", "chosen", "guessed")
"""First words of the comments that the program writes and may exchange."""
Notes = Mapping[Key, str]
Block = Callable[[Key], bool]
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./]*\Z")
_RESERVED = re.compile(r"(?i:true|false|null|yes|no|on|off|y|n)\Z")
_OWN = re.compile(rf"#\s*(?:{'|'.join(LEADS)})\b")


def yaml_text(value: Mapping[str, Any], notes: Notes, block: Block) -> str:
    """Write a mapping as a YAML file.

    Parameters
    ----------
    value
        Of mappings, lists, texts, numbers, booleans and None.
    notes
        Comments by the keys of values, without their sign.
    block
        Whether the mapping or list at a key is written line by line; else it is in flow style.
    """
    return "\n".join(_block_lines(value, (), notes, block)) + "\n"


def flow_text(value: Any) -> str:
    """Write a value in flow style; numbers to 1e-7."""
    if isinstance(value, Mapping):
        rows = (f"{flow_text(key)}: {flow_text(inner)}" for key, inner in value.items())
        return "{" + ", ".join(rows) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(flow_text(inner) for inner in value) + "]"
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return f"{round(value, 7) + 0.0:.10g}"
    text = str(value)
    plain = _PLAIN.match(text) and not _RESERVED.match(text)
    return text if plain else json.dumps(text, ensure_ascii=False)


def _block_lines(value: Any, key: Key, notes: Notes, block: Block) -> list[str]:
    """The lines of a mapping or list, from column 0 on."""
    lines = []
    rows = value.items() if isinstance(value, Mapping) else enumerate(value)
    for name, inner in rows:
        inside = (*key, name)
        lead = f"{flow_text(name)}:" if isinstance(value, Mapping) else "-"
        note = f"  # {notes[inside]}" if inside in notes else ""
        if not (block(inside) and inner and isinstance(inner, (Mapping, list, tuple))):
            lines.append(f"{lead} {flow_text(inner)}{note}")
            continue
        below = _block_lines(inner, inside, notes, block)
        if lead == "-":
            lines += [f"- {below[0]}", *(f"  {line}" for line in below[1:])]
        else:
            lines += [lead + note, *(f"  {line}" for line in below)]
    return lines


def changed_text(
    text: str, before: Any, after: Any, *, notes: Notes | None = None, block: Block | None = None
) -> str:
    """Change a text that says one value so that it says another one.

    Parameters
    ----------
    text
        A YAML text.
    before, after
        The mapping that it says, and the one that it is to say.
    notes, block
        As of `yaml_text`, for what is changed or new.

    Raises
    ------
    InputError
        If the text does not have what is to be changed.
    """
    told = notes or {}
    touched: list[Key] = []
    for key, kind, value in _differences(before, after, ()):
        text = own_copy(text, key[:-1] if kind == "add" else key, "one")
        if kind == "rename":
            text = _renamed(text, key, str(value))
            key = (*key[:-1], str(value))
        elif kind == "remove":
            text = _without(text, key)
        elif kind == "add":
            text = _with(text, key, value, told, block or (lambda key: False))
        else:
            node = node_at(text, key).node
            assert node is not None
            text = exchanged(text, node, flow_text(value))
        touched.append(key)
    for key in _noted(after, ()):
        if any(key[: len(one)] == one or one[: len(key)] == key for one in touched):
            text = _commented(text, key, told.get(key, ""))
    return text


def _differences(before: Any, after: Any, key: Key) -> Iterator[tuple[Key, str, Any]]:
    """What is to be renamed, removed, set and added: the key, which of these, and the new value."""
    gone = [name for name in before if name not in after]
    new = [name for name in after if name not in before]
    for name in list(gone):
        alike = next((other for other in new if after[other] == before[name]), None)
        if alike is not None:
            yield (*key, name), "rename", alike
            gone.remove(name)
            new.remove(alike)
    for name in gone:
        yield (*key, name), "remove", None
    for name, value in after.items():
        if name in new:
            yield (*key, name), "add", value
        elif name in before and before[name] != value:
            yield from _inner_differences(before[name], value, (*key, name))


def _inner_differences(before: Any, after: Any, key: Key) -> Iterator[tuple[Key, str, Any]]:
    """The differences of two values at one key."""
    if isinstance(before, Mapping) and isinstance(after, Mapping) and before and after:
        yield from _differences(before, after, key)
    elif _rows(before) and _rows(after) and len(before) == len(after):
        for row, (one, other) in enumerate(zip(before, after, strict=True)):
            if one != other:
                yield from _differences(one, other, (*key, row))
    else:
        yield key, "set", after


def _rows(value: Any) -> bool:
    """Whether a value is a list of mappings."""
    return isinstance(value, list) and all(isinstance(row, Mapping) for row in value)


def _item(text: str, key: Key) -> tuple[Node, Item]:
    """The mapping that a key is in, and its entry."""
    parent = mapping_at(text, key[:-1])
    item = parent.item(str(key[-1]))
    assert item is not None and item.key is not None
    return parent, item


def _renamed(text: str, key: Key, name: str) -> str:
    item = _item(text, key)[1]
    assert item.key is not None
    return exchanged(text, item.key, flow_text(name))


def _without(text: str, key: Key) -> str:
    """The text without an entry of a mapping, and without its lines where it has its own."""
    parent, item = _item(text, key)
    assert item.key is not None
    if len(parent.items) == 1:
        return exchanged(text, parent, "{}")
    row = parent.items.index(item)
    if parent.flow:
        if row:
            return text[: parent.items[row - 1].value.end] + text[item.value.end :]
        following = parent.items[1].key
        assert following is not None
        return text[: item.key.start] + text[following.start :]
    end = text.find("\n", item.value.end)
    end = len(text) if end < 0 else end + 1
    begin = item.key.start - column_of(text, item.key.start)
    if text[begin : item.key.start].strip():  # the first of a list's entry, after its dash
        following = parent.items[1].key
        assert following is not None
        return text[: item.key.start] + text[following.start :]
    return text[:begin] + text[end:]


def _with(text: str, key: Key, value: Any, notes: Notes, block: Block) -> str:
    """The text with one entry more."""
    name = str(key[-1])
    found = node_at(text, key[:-1]).node
    if found is None or found.kind != "mapping":
        assert found is not None
        space = " " if text[found.start - 1 : found.start] == ":" else ""
        return exchanged(text, found, space + flow_text({name: value}))
    written = flow_text(value)
    block_written = (
        not found.flow and block(key) and bool(value) and isinstance(value, (Mapping, list))
    )
    if block_written:
        first = found.items[0].key
        assert first is not None
        inset = " " * (column_of(text, first.start) + 2)
        lines = _block_lines(value, key, notes, block)
        written = "".join(f"{new_line(text)}{inset}{line}" for line in lines)
    lead = flow_text(name)
    found_text = with_entry(text, found, lead, written)
    return (
        found_text.replace(f"{lead}: {written}", f"{lead}:{written}", 1)
        if block_written
        else found_text
    )


def _noted(value: Any, key: Key) -> Iterator[Key]:
    """The keys of a value and of what is in it."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield (*key, name)
            yield from _noted(inner, (*key, name))
    elif _rows(value):
        for row, inner in enumerate(value):
            yield from _noted(inner, (*key, row))


def _commented(text: str, key: Key, words: str) -> str:
    """The text with a comment behind the value of a key: an own one is exchanged, another stays."""
    node = node_at(text, key).node
    if node is None or (node.kind == "mapping" and not node.flow):
        return text
    line = text.find("\n", node.end)
    line = len(text) if line < 0 else line
    if text[line - 1 : line] == "\r":
        line -= 1
    rest = text[node.end : line].strip()
    if (rest and not rest.startswith("#")) or (rest and not _OWN.match(rest)):
        return text
    return text[: node.end] + (f"  # {words}" if words else "") + text[line:]
