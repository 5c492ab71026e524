"""Count the functions of the package that loading and running a study passes through.

    python tools/walk.py trainer_clearance trainer_reach        # how many, by room
    python tools/walk.py trainer_clearance --list                # each of them

Every module is imported first, so that what an import does is not counted. A compiled function is
counted where it is called from Python, not where another compiled one calls it.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import sys
import threading
from collections import Counter
from pathlib import Path
from types import CodeType, FrameType

import workbench

PACKAGE = Path(workbench.__file__).parent
NOT_WALKED = {"workbench.__main__", "workbench.contact.kernels.gpu"}
"""Modules that are a program, or need a card."""


def functions_walked(study: str) -> set[tuple[str, str]]:
    """File and qualified name of each function that loading and running a study calls."""
    called: set[CodeType] = set()

    def note(frame: FrameType, event: str, argument: object) -> None:
        if event == "call":
            called.add(frame.f_code)

    threading.setprofile(note)
    sys.setprofile(note)
    try:
        workbench.run(workbench.load_study(study))
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    return {
        (Path(code.co_filename).relative_to(PACKAGE).as_posix(), code.co_qualname)
        for code in called
        if code.co_filename.startswith(f"{PACKAGE}/")
        and code.co_flags & inspect.CO_OPTIMIZED  # else the body of a class
        and not code.co_name.startswith("<")  # a comprehension is part of its function
    }


def main(arguments: list[str]) -> int:
    """Print the counts of some studies."""
    for module in pkgutil.walk_packages(workbench.__path__, "workbench."):
        if module.name not in NOT_WALKED:
            importlib.import_module(module.name)
    for study in [name for name in arguments if not name.startswith("--")]:
        found = functions_walked(study)
        print(f"{study}: {len(found)} functions in {len({file for file, _ in found})} files")
        rooms = Counter(str(Path(file).parent) if "/" in file else file for file, _ in found)
        for room, count in rooms.most_common():
            print(f"{count:5} {room}")
        if "--list" in arguments:
            print("\n".join(f"{file}: {name}" for file, name in sorted(found)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
