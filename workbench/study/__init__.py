"""Make a study without a file: `workbench.study(environment, people=..., cases=..., criteria=[...])`;
`help(workbench.study.__call__)` says all of it. And the room of studies: one module a question;
run(study) composes the solvers into a Result.

Python gives `workbench` the attribute `study` as soon as anything in this room is loaded. So the
room itself is what the public name means, and can be called.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from inspect import Signature, signature
from types import ModuleType

from workbench.model.study import Study


class _Room(ModuleType):
    """A room whose name is a verb too."""

    @property
    def __call__(self) -> Callable[..., Study]:
        from workbench.files.study.stating import study  # not loaded with every study
        from workbench.model.arguments import checked

        return checked(study)

    @property
    def __signature__(self) -> Signature:
        return signature(self.__call__)


sys.modules[__name__].__class__ = _Room
