"""Human factors with sphere bodies: pose a body, put it into a cockpit, ask what it touches.

    import workbench as wb
    study = wb.load_study("trainer_clearance")
    result = wb.run(study)

The public names are declared in `__init__.pyi`. Each is imported when it is first used, so that
`import workbench` is fast. Public functions check their arguments (see workbench.model.arguments):
a wrong one is a UsageError that names it.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as in typing, which takes some milliseconds to import
if TYPE_CHECKING:
    from typing import Any

__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    """Import a public name; functions are wrapped so that they check their arguments."""
    if "_import" not in globals():
        # not before a name is wanted: until the command line has seen to Ctrl-C, little is imported
        import lazy_loader

        public, _, names = lazy_loader.attach_stub(__name__, __file__)
        globals().update(_import=public, __all__=[*names, "__version__"])
    if name == "__all__":
        return globals()["__all__"]
    if name == "study":  # a room too, whose package has this name in any case once it is loaded
        import workbench.study as room

        return room
    found = globals()["_import"](name)
    if callable(found) and not isinstance(found, type):
        from workbench.model.arguments import checked

        found = checked(found)
        found.__module__ = __name__  # where pickle finds it
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    names: list[str] = __getattr__("__all__")
    return names
