"""YAML text with the place of every value, so that one of them can be exchanged and all other bytes
stay as they are: comments, order, anchors and the style in which mappings are written."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import yaml

from workbench.errors import InputError

__all__ = ["Item", "Node", "marked", "walked"]


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
