"""Change what a YAML text says, and keep its comments, order, anchors and style.

`changed_text` compares the values that a text says with those that it is to say and exchanges what
differs at the marks of the parser; all other bytes stay. A value that an anchor shares is changed
in all places or in one alone; whoever asks for the change says which.

Notes say in a comment how a figure was got. They begin with one of `LEADS`: such a comment is the
program's own and is exchanged with its figure. Any other comment stays.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import yaml

from workbench.errors import InputError
from workbench.files.yaml_text import parse_yaml

__all__ = [
    "LEADS",
    "Item",
    "Key",
    "Node",
    "SharedValueError",
    "Sharing",
    "changed_text",
    "flow_text",
    "marked",
    "walked",
    "yaml_text",
]

LEADS = ("picked", "fitted", "typed", "assumed", "chosen", "guessed")
"""First words of the comments that the program writes and may exchange."""
MOST_SHARED = 200
"""Places of shared values that are written out for one change."""
BOM = "\ufeff"
Sharing = Literal["ask", "all", "one"]
"""What becomes of a value that several places share: it is asked about, changed in all of them, or
in one alone."""
Key = tuple[str | int, ...]
Notes = Mapping[Key, str]
Block = Callable[[Key], bool]
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./]*\Z")
_RESERVED = re.compile(r"(?i:true|false|null|yes|no|on|off|y|n)\Z")
_OWN = re.compile(rf"#\s*(?:{'|'.join(LEADS)})\b")
_COMMA = re.compile(r"(#[^\n]*)|,")


class SharedValueError(InputError):
    """A value that is to be changed is shared with other places, and nobody said what becomes of
    these."""


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
    return "\n".join(_lines(value, (), notes, block)) + "\n"


def flow_text(value: Any) -> str:
    """Write a value in flow style; whole numbers without a point."""
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
        return repr(_plain(value)).replace("inf", ".inf").replace("nan", ".nan")
    text = str(value)
    plain = _PLAIN.match(text) and not _RESERVED.match(text)
    return text if plain else json.dumps(text, ensure_ascii=False)


def _plain(value: Any) -> Any:
    """A value as it comes back from a text: whole numbers without a point, and nothing shared."""
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    whole = isinstance(value, float) and value.is_integer() and abs(value) < 1e15
    return int(value) if whole else value


def _same(one: Any, other: Any) -> bool:
    """Whether two values are the same in a text: True is not 1, and the order of keys is nothing."""
    return json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True)


def _rows(value: Any) -> list[tuple[str | int, Any]]:
    """The entries of a mapping or list, by their keys or numbers."""
    return list(value.items() if isinstance(value, Mapping) else enumerate(value))


def _lines(value: Any, key: Key, notes: Notes, block: Block) -> list[str]:
    """The lines of a mapping or list, from column 0 on."""
    rows = (_entry_lines(name, inner, (*key, name), notes, block) for name, inner in _rows(value))
    return [line for row in rows for line in row]


def _entry_lines(name: str | int, value: Any, key: Key, notes: Notes, block: Block) -> list[str]:
    """The lines of one entry of a mapping, or of a list where its name is a number."""
    lead = "-" if isinstance(name, int) else f"{flow_text(name)}:"
    note = f"  # {notes[key]}" if key in notes else ""
    if not (block(key) and value and isinstance(value, (Mapping, list, tuple))):
        return [f"{lead} {flow_text(value)}{note}"]
    below = _lines(value, key, notes, block)
    if lead == "-":
        return [f"- {below[0]}", *(f"  {line}" for line in below[1:])]
    return [lead + note, *(f"  {line}" for line in below)]


def changed_text(
    text: str,
    after: Any,
    *,
    sharing: Sharing = "one",
    notes: Notes | None = None,
    block: Block = lambda key: False,
) -> str:
    """Change a text so that it says other values.

    Parameters
    ----------
    text
        A YAML text of a mapping or list, with its byte order mark and its line ends as they are.
    after
        What it is to say. An entry whose value another key has now is renamed, and so is one of a
        text or number whose place in the mapping another one takes; new entries stand behind
        those that they follow.
    sharing
        What becomes of values that an anchor shares. With "all" the text may say more than `after`.
    notes
        Comments by the keys of values, for what is changed or new; all comments stay if None.
    block
        As of `yaml_text`, for what is new.

    Raises
    ------
    SharedValueError
        If a value is shared and `sharing` is "ask".
    InputError
        If the text is not YAML, or cannot be changed at these places.
    """
    body = text.removeprefix(BOM)
    wanted = _plain(after)
    for _ in range(MOST_SHARED):
        place = _Text(body, notes, block)
        changes = list(place.changes(place.root, wanted, (), None))
        shared = next(
            (one for one in changes if one.lost or (one.shared and sharing != "all")), None
        )
        if shared is None:
            break
        if shared.lost is None and sharing == "ask":
            raise SharedValueError(place.shared_words(shared))
        node = shared.lost or shared.shared
        assert node is not None
        body = place.unshared(node)
    else:
        raise InputError("anchors within anchors too deep to change one place alone")
    body = _applied(body, changes)
    if notes is not None:
        place = _Text(body, notes, block)
        touched = [one.key for one in changes]
        body = _applied(body, list(place.comments(place.root, (), touched)))
    if sharing != "all" and not _same(_plain(parse_yaml(body, "text").value), wanted):
        raise InputError("the text cannot be changed at these places so that its comments stay")
    return text[: len(text) - len(text.removeprefix(BOM))] + body


@dataclass(frozen=True)
class _Change:
    """Another text in the place of some characters.

    Parameters
    ----------
    key
        Of the value that is changed.
    shared
        The first node on the way to it that other places share.
    lost
        A value with an anchor within what goes that other places need.
    """

    start: int
    end: int
    text: str
    key: Key
    shared: Node | None = None
    lost: Node | None = None


def _applied(text: str, changes: Sequence[_Change]) -> str:
    """The text with changes made; those that are the same for several places are one."""
    pieces = []
    done = 0
    rows = dict.fromkeys((one.start, one.end, one.text, one.key[-1:]) for one in changes)
    for start, end, words, _ in sorted(rows, key=lambda row: row[:2]):
        if start < done:
            raise InputError("places that share a value are to say different things")
        pieces += [text[done:start], words]
        done = end
    return "".join(pieces) + text[done:]


class _Text:
    """A YAML text with its nodes, the value of each, and how often each anchor is used."""

    def __init__(self, text: str, notes: Notes | None, block: Block) -> None:
        self.text = text
        self.notes = notes
        self.block = block
        self.root = marked(text)
        self.values: dict[Node, Any] = {}
        todo = [(self.root, _plain(parse_yaml(text, "text").value))]
        while todo:
            node, value = todo.pop()
            self.values[node] = value
            inner = [value for _, value in _rows(value)] if node.items else []
            todo += zip((item.value for item in node.items), inner, strict=True)
        self.places: dict[Node, list[Node]] = {}
        """Of each node with an anchor or alias, all that share its value, the anchored one first."""
        current: dict[str, list[Node]] = {}
        for node in walked(self.root):
            if node.anchor and node.kind != "alias":
                current[node.anchor] = []
            if node.anchor:
                current[node.anchor].append(node)
                self.places[node] = current[node.anchor]

    def changes(self, node: Node, after: Any, key: Key, shared: Node | None) -> Iterator[_Change]:
        """What changes where a value is to be another one."""
        before = self.values[node]
        if len(self.places.get(node, ())) > 1:
            shared = shared or node
        if node.kind == "alias":
            node = self.places[node][0]
        if before and after and isinstance(before, dict) and isinstance(after, dict):
            yield from self.mapping_changes(node, after, key, shared)
        elif before and after and isinstance(before, list) and isinstance(after, list):
            yield from self.list_changes(node, after, key, shared)
        elif not _same(before, after):
            yield self.exchange(node, after, key, shared)

    def exchange(self, node: Node, after: Any, key: Key, shared: Node | None) -> _Change:
        """Another value in the place of a whole one; its anchor stays."""
        start = node.start
        words = f"&{node.anchor} {flow_text(after)}" if node.anchor else flow_text(after)
        if node.items and not node.flow:  # from its own lines to that of its key
            start = len(self.text[:start].rstrip())
            start = start if self.text[start - 1] in ":-" else node.start
        if start == node.end or start < node.start:
            before = self.text[start - 1 : start]
            words = words if before.isspace() else f" {words}" if before in ":-" else f": {words}"
        lost = self.lost([item.value for item in node.items])
        return _Change(start, node.end, words, key, shared, lost)

    def mapping_changes(
        self, node: Node, after: Mapping[str, Any], key: Key, shared: Node | None
    ) -> Iterator[_Change]:
        before: dict[str, Any] = self.values[node]
        renamed = _renamed(before, after)
        items: dict[str | int, Item] = {}
        gone = []
        for row, (old, item) in enumerate(zip(before, node.items, strict=True)):
            name = renamed.get(old, old)
            if name not in after:
                gone.append(row)
                continue
            items[name] = item
            if name != old and item.key is not None:
                yield _Change(item.key.start, item.key.end, flow_text(name), (*key, name), shared)
            yield from self.changes(item.value, after[name], (*key, name), shared)
        yield from self.fewer(node, gone, key, shared, () if items else _rows(after))
        if items:
            yield from self.more(node, items, _rows(after), key, shared)

    def list_changes(
        self, node: Node, after: list[Any], key: Key, shared: Node | None
    ) -> Iterator[_Change]:
        before: list[Any] = self.values[node]
        short = min(len(before), len(after))
        first = next((k for k in range(short) if not _same(before[k], after[k])), short)
        last = next(
            (k for k in range(short - first) if not _same(before[-1 - k], after[-1 - k])),
            short - first,
        )
        if len(after) > len(before) and first == 0 and last == short:
            yield self.exchange(node, after, key, shared)  # nothing stands in front of new ones
            return
        for row in range(first, short - last):
            yield from self.changes(node.items[row].value, after[row], (*key, row), shared)
        gone = list(range(short - last, len(before) - last))
        yield from self.fewer(node, gone, key, shared)
        items: dict[str | int, Item] = dict(enumerate(node.items[: short - last]))
        yield from self.more(node, items, _rows(after)[: len(after) - last], key, shared)

    def more(
        self,
        node: Node,
        items: dict[str | int, Item],
        rows: list[tuple[str | int, Any]],
        key: Key,
        shared: Node | None,
    ) -> Iterator[_Change]:
        """New entries, each behind the one that it follows; without one, behind the last."""
        behind = list(items.values())[-1:]
        for name, value in rows:
            if name in items:
                behind = [items[name]]
                continue
            end = behind[0].value.end
            lead = ", "
            if not node.flow:
                end = self.line_end(end)
                lead = self.break_of(node)
            yield _Change(end, end, lead + self.entry(node, name, value, key), (*key, name), shared)

    def fewer(
        self,
        node: Node,
        gone: Sequence[int],
        key: Key,
        shared: Node | None,
        instead: Sequence[tuple[str | int, Any]] = (),
    ) -> Iterator[_Change]:
        """Entries that go, by their rows; instead: what stands in the place of all of them."""
        lost = self.lost([node.items[row].value for row in gone])
        begins = [self.begin(node, item) for item in node.items]
        ends = [item.value.end for item in node.items]
        if gone and len(gone) == len(node.items):
            between = ", " if node.flow else self.break_of(node)
            words = between.join(self.entry(node, name, value, key) for name, value in instead)
            yield _Change(begins[0], ends[-1], words, key, shared, lost)
            return
        front = next(row for row in range(len(begins)) if row not in gone)
        for row in gone[front:]:
            begin, end = ends[row - 1], ends[row]
            words = "" if not node.flow else self.kept_comments(node, begin, begins[row])
            if not node.flow:
                line = self.line_end(end)
                own = self.own_comments(end, line)
                begin = self.line_end(self.text.rfind("\n", 0, begins[row])) if own else begins[row]
                end = line if own else self.text.index("#", end)
            yield _Change(begin, end, words, (*key, row), shared, lost)
        if front:
            rows = range(front)
            words = "".join(self.kept_comments(node, ends[k], begins[k + 1]) for k in rows)
            yield _Change(begins[0], begins[front], words, key, shared, lost)

    def own_comments(self, begin: int, end: int) -> bool:
        """Whether nobody else wrote a comment there."""
        words = self.text[begin:end].strip()
        return not words or (self.notes is not None and _OWN.match(words) is not None)

    def kept_comments(self, node: Node, begin: int, end: int) -> str:
        """The comments between two entries, where one of these goes."""
        between = self.text[begin:end]
        if node.flow:
            return _COMMA.sub(r"\1", between) if "#" in between else ""
        line = self.line_end(begin)
        return self.text[line if self.own_comments(begin, line) else begin : end].lstrip()

    def entry(self, node: Node, name: str | int, value: Any, key: Key) -> str:
        """A new entry in the style of its mapping or list."""
        if node.flow:
            words = flow_text(value)
            return words if isinstance(name, int) else f"{flow_text(name)}: {words}"
        lines = _entry_lines(name, value, (*key, name), self.notes or {}, self.block)
        return self.break_of(node).join(lines)

    def break_of(self, node: Node) -> str:
        """What lies between two lines of a mapping or list in block style."""
        first = self.begin(node, node.items[0])
        column = first - (self.text.rfind("\n", 0, first) + 1)
        return ("\r\n" if "\r\n" in self.text else "\n") + " " * column

    def begin(self, node: Node, item: Item) -> int:
        """The first character of an entry: in a list in block style, its dash."""
        if item.key is not None:
            return item.key.start
        return item.value.start if node.flow else self.text.rfind("-", 0, item.value.start)

    def line_end(self, at: int) -> int:
        """Where the line of a character ends, before what breaks it."""
        line = self.text.find("\n", max(at, 0))
        line = len(self.text) if line < 0 else line
        return line - (self.text[line - 1 : line] == "\r")

    def lost(self, nodes: Sequence[Node]) -> Node | None:
        """A value with an anchor within some nodes, of which not all places are within them."""
        within = [inner for node in nodes for inner in walked(node)]
        for one in within:
            others = () if one.kind == "alias" else self.places.get(one, ())
            if not all(other in within for other in others):
                return one
        return None

    def shared_words(self, change: _Change) -> str:
        """That a value is shared, and where its anchor is."""
        assert change.shared is not None
        every = self.places[change.shared]
        line = self.text.count("\n", 0, every[0].start) + 1
        name = " ".join(str(part + 1) if isinstance(part, int) else part for part in change.key)
        return (
            f"{name} is shared by {len(every)} places (&{every[0].anchor} in line {line}): "
            "change all of them, or this one only?"
        )

    def unshared(self, node: Node) -> str:
        """The text with one place of a shared value written out; the anchor goes to the next one."""
        plain = flow_text(self.values[node])
        if node.kind == "alias":
            return self.text[: node.start] + plain + self.text[node.end :]
        after = self.places[node][1]
        begin = node.start + len(f"&{node.anchor}")
        while self.text[begin].isspace() and (node.flow or node.kind == "scalar"):
            begin += 1
        moved = f"&{node.anchor} {plain}"
        kept = self.text[: node.start] + self.text[begin : after.start]
        return kept + moved + self.text[after.end :]

    def comments(self, node: Node, key: Key, touched: Sequence[Key]) -> Iterator[_Change]:
        """The comments behind values that were touched: own ones are exchanged, others stay."""
        for (name, value), item in zip(_rows(self.values[node]), node.items, strict=True):
            inside = (*key, name)
            inner = item.value
            near = any(inside[: len(one)] == one[: len(inside)] for one in touched)
            if near and item.key is not None and (inner.flow or not inner.items):
                line = self.line_end(inner.end)
                rest = self.text[inner.end : line].strip()
                if not rest or _OWN.match(rest):
                    note = (self.notes or {}).get(inside, "")
                    yield _Change(inner.end, line, f"  # {note}" if note else "", inside)
            if inner.kind == "mapping" or (inner.items and isinstance(value[0], dict)):
                yield from self.comments(inner, inside, touched)


def _renamed(before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, str]:
    """New names by old ones, of values that are the same and of scalars at the same place."""
    found: dict[str, str] = {}
    places = {(old, new) for old, new in zip(before, after, strict=False)}
    for old in before:
        for new in after if old not in after else ():
            scalars = not isinstance(before[old], (dict, list)) and not isinstance(
                after[new], (dict, list)
            )
            if new in before or new in found.values():
                continue
            if _same(before[old], after[new]) or (scalars and (old, new) in places):
                found[old] = new
                break
    return found


# YAML text with the place of every value, so that one of them can be exchanged and all other bytes
# stay as they are: comments, order, anchors and the style in which mappings are written.


@dataclass(eq=False)
class Node:
    """A value as it stands in a text.

    Parameters
    ----------
    kind
        "scalar", "sequence", "mapping" or "alias".
    start, end
        Its characters; those of a mapping in block style end with its last value.
    anchor
        The name that it is given (&name), or that it refers to (*name); "" where there is none.
    text
        Of a scalar.
    flow
        Whether it is written with brackets or braces.
    """

    kind: str
    start: int
    end: int
    anchor: str = ""
    text: str = ""
    flow: bool = False
    items: list[Item] = field(default_factory=list)

    def item(self, key: str) -> Item | None:
        """The entry of a mapping with a key."""
        return next(
            (item for item in self.items if item.key is not None and item.name == key), None
        )


@dataclass(eq=False)
class Item:
    """An entry of a mapping, or of a sequence, which has no key."""

    key: Node | None
    value: Node

    @property
    def name(self) -> str:
        """The key's text, "" in a sequence."""
        return self.key.text if self.key is not None else ""


def marked(text: str) -> Node:
    """Read where everything stands in the text of one YAML document.

    Raises
    ------
    InputError
        If it is not YAML, or holds nothing.
    """
    opened: list[Node] = []
    keys: list[Node | None] = []
    root: Node | None = None
    try:
        for event in yaml.parse(text, Loader=yaml.CSafeLoader):
            if isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
                closed = opened.pop()
                keys.pop()
                closed.end = _end(closed, event)
            elif isinstance(event, yaml.NodeEvent):
                node = _node(event, text)
                _put(node, opened, keys)
                root = root or node
                if node.kind in ("mapping", "sequence"):
                    opened.append(node)
                    keys.append(None)
    except yaml.YAMLError as error:
        raise InputError(f"not YAML: {str(error).splitlines()[0]}") from None
    if root is None:
        raise InputError("holds no value")
    return root


def _node(event: yaml.NodeEvent, text: str) -> Node:
    """The node that an event begins."""
    start, end = _places(event)
    anchor = event.anchor or ""
    if isinstance(event, yaml.AliasEvent):
        return Node("alias", start, end, anchor)
    if isinstance(event, yaml.ScalarEvent):
        if event.style in ("|", ">"):
            end = start + len(text[start:end].rstrip())
        return Node("scalar", start, end, anchor, str(event.value))
    kind = "mapping" if isinstance(event, yaml.MappingStartEvent) else "sequence"
    flow = isinstance(event, yaml.CollectionStartEvent) and bool(event.flow_style)
    return Node(kind, start, end, anchor, flow=flow)


def _places(event: yaml.Event) -> tuple[int, int]:
    """The characters at which an event begins and ends."""
    assert event.start_mark is not None and event.end_mark is not None
    return event.start_mark.index, event.end_mark.index


def _end(closed: Node, event: yaml.Event) -> int:
    """Where a list or mapping ends: one in block style with its last value."""
    if closed.flow or not closed.items:
        return _places(event)[1]
    return closed.items[-1].value.end


def _put(node: Node, opened: list[Node], keys: list[Node | None]) -> None:
    """Store a node in the list or mapping that is open."""
    if not opened:
        return
    parent = opened[-1]
    if parent.kind == "sequence":
        parent.items.append(Item(None, node))
    elif keys[-1] is None:
        keys[-1] = node
    else:
        parent.items.append(Item(keys[-1], node))
        keys[-1] = None


def walked(node: Node) -> Iterator[Node]:
    """A node and all below it, in the order of the text."""
    todo = [node]
    while todo:
        one = todo.pop()
        yield one
        for item in reversed(one.items):
            todo.append(item.value)
