"""A study file that is being read: the faults and the input files found so far."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from workbench.errors import InputError, one_of
from workbench.files.schema import error_at
from workbench.files.study.parts import StudyParts
from workbench.files.yaml_text import Document
from workbench.model.environment import Environment

__all__ = ["Key", "Work"]

Key = tuple[str | int, ...]


@dataclass
class Work:
    """A study file that is being read.

    inputs: the files it names, by role; environments: those that are loaded, by their files; notes:
    what is no fault and may be a mistake.
    """

    path: Path
    document: Document
    parts: StudyParts
    faults: list[str]
    inputs: dict[str, Path] = field(default_factory=dict)
    environments: dict[Path, Environment] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def fault(self, key: Key, what: str) -> None:
        """Report a fault of the value at a key."""
        self.add([error_at(self.document, key, what)])

    def check_name(
        self,
        key: Key,
        name: str,
        valid: Iterable[str],
        what: str,
        *,
        words: Mapping[str, str] | None = None,
    ) -> bool:
        """Report a name that is not valid; return whether it is.

        Parameters
        ----------
        key
            Where the name stands.
        name, valid
            The name, and those that there are.
        what
            What is wrong with a name that is not valid, without a hint at the valid ones.
        words
            What the valid names mean, in words.
        """
        names = list(valid)
        if name not in names:
            self.fault(key, f"{what}; {one_of(name, names, words=words or {})}")
        return name in names

    def errors(self, key: Key, error: InputError) -> None:
        """Report the faults of something that is named at a key."""
        self.add(error_at(self.document, key, problem) for problem in error.problems)

    def add(self, lines: Iterable[str]) -> None:
        """Report lines, each once."""
        self.faults += [line for line in dict.fromkeys(lines) if line not in self.faults]
