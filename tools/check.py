"""Check the code without running it: layout, lint, types, and the rules of the house.

    python tools/check.py            # all of them
    python tools/check.py house      # one of: format, lint, types, house

Each fault is a line `file:line: what is wrong`. The exit code is 0 where there is none, else 1.

The rules of the house:

- A room of the package imports only the rooms below it (`LAYERS`).
- A library is imported in its home alone (`HOMES`), so that it can be exchanged there.
- No module imports another module's underscore name, catches every exception, forwards `**kwargs`, or is a
  drawer for everything (utils, helpers, common, misc).
- Every public function and class has a docstring.
- No file names the machine that it was made on.
- Scripts beside the package (benchmarks, docs, tools) import only what is there.
- Tests import public names from `workbench`, commands from `workbench.cli`, and beyond these only the
  modules of `tests/inner_imports.txt`. Kernels are imported only by the files that are named there
  beside them, next to a slow version that they are compared with.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "workbench"
LAYERS = [
    {"errors"},
    {"compiled_records"},
    {"compiled_linked"},
    {"compiled", "threads"},
    {"model"},
    {"geometry"},
    {"files"},
    {"body"},
    {"contact"},
    {"posture"},
    {"motion"},
    {"crash", "sight", "strain"},
    {"study"},
    {"draw"},
    {"report", "live"},
    {"cli"},
]
"""Rooms from the lowest to the highest; those of one row never see each other."""
COMPILERS = {
    "compiled.py",
    "compiled_linked.py",
    "compiled_records.py",
    "geometry/simd8.py",
    "geometry/simd4.py",
}
HOMES = {
    "numba": COMPILERS,
    "llvmlite": COMPILERS,
    "trimesh": {"files/meshes/scene.py", "files/environment_doubts.py"},
    "collada": {"files/meshes/dae.py"},
    "pydantic": {"files"},
    "yaml": {"files"},
    "scipy": {"files", "body", "contact", "posture", "motion", "sight", "strain"},
    "PIL": {"draw"},
    "contourpy": {"draw/contours.py"},
    "jinja2": {"report"},
    "markupsafe": {"report"},
    "cyclopts": {"cli"},
    "rich": {"cli/progress.py"},
    "pyvista": {"draw/logical_window.py"},
    "imageio_ffmpeg": {"draw/films/film.py"},
    "manifold3d": {"body", "files/meshes/parts.py", "files/meshes/mesh_validation.py"},
    "mujoco": {"crash/simulated.py"},
    "distributed": {"study/executors.py"},
    "threadpoolctl": {"study/accommodation/population_bodies.py"},
    "duckdb": {"files/parquet.py"},
    "pandas": {"report/result_rows.py"},
    "starlette": {"live"},
    "uvicorn": {"live"},
    "anywidget": {"draw/web/widget.py"},
    "traitlets": {"draw/web/widget.py"},
}
"""The files or rooms that may import a library."""
DRAWERS = {"utils", "helpers", "common", "misc"}
FORWARDS = {
    "cli/body.py",
    "model/arguments.py",
    "model/kept.py",
    "compiled.py",
    "compiled_linked.py",
    "contact/collide.py",
}
"""Files whose functions may take `**kwargs`: one option for each measure, and decorators."""
CATCHES = {"cli/application.py", "live/describe_desk.py", "live/desk.py", "live/server.py"}
"""Files that may catch every exception: an exit code and one line for what nobody expects; a
question that fails, which must not end the bench."""
TEXTS = {".py", ".md", ".yaml", ".toml", ".cff", ".j2"}
PLACES = ("/wo" + "rk/", "/ro" + "ot/", "is" + "sue #", "sess" + "ion ends")

INNER_IMPORTS = ROOT / "tests" / "inner_imports.txt"
"""The modules that tests import besides the public names, a line each: the module, and for kernels
the test files that may."""
PUBLIC = {"workbench", "workbench.cli"}

Fault = tuple[Path, int, str]


def tracked(*patterns: str) -> list[Path]:
    """Files that git tracks: what else lies in the checkout is nobody's business."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", *patterns], cwd=ROOT, capture_output=True, check=True
    )
    names = listed.stdout.decode().split("\0")
    return [ROOT / name for name in names if name and (ROOT / name).is_file()]


def imported_modules(tree: ast.Module) -> Iterator[tuple[str, ast.stmt]]:
    """Every import of a file, wherever it stands."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module, node


def layer_of(room: str) -> int:
    """Index of a room in LAYERS."""
    return next(index for index, rooms in enumerate(LAYERS) if room in rooms)


def check_imports(path: Path, tree: ast.Module) -> Iterator[Fault]:
    """Find imports against the layers, of libraries away from home, and of underscore names."""
    inside = path.relative_to(PACKAGE)
    own_room = inside.parts[0].removesuffix(".py")
    for module, node in imported_modules(tree):
        if module.startswith("workbench.") and own_room not in ("__init__", "__main__"):
            room = module.split(".")[1]
            if room != own_room and layer_of(room) >= layer_of(own_room):
                yield path, node.lineno, f"{own_room} may not import {module}"
        if module.startswith("workbench") and isinstance(node, ast.ImportFrom):
            for alias in node.names:
                if alias.name.startswith("_") and not alias.name.startswith("__"):
                    yield path, node.lineno, f"imports {alias.name}, a private name of {module}"
        homes = HOMES.get(module.split(".")[0])
        here = inside.as_posix()
        if homes and not any(here == home or here.startswith(home + "/") for home in homes):
            yield path, node.lineno, f"{module} is at home in {', '.join(sorted(homes))}"


def check_definitions(path: Path, tree: ast.Module) -> Iterator[Fault]:
    """Find public names without docstrings, forwarded keywords and exceptions caught blindly."""
    inside = path.relative_to(PACKAGE).as_posix()
    if path.stem in DRAWERS:
        yield path, 1, "a file is named by what it is about"
    for node in tree.body:
        public = isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_")
        if public and not ast.get_docstring(node):
            yield path, node.lineno, f"{node.name} has no docstring"
    for node in ast.walk(tree):
        forwards = isinstance(node, ast.FunctionDef) and node.args.kwarg is not None
        if forwards and inside not in FORWARDS:
            yield path, node.lineno, f"{node.name} forwards keywords"
        if isinstance(node, ast.ExceptHandler):
            caught = ast.unparse(node.type) if node.type else "everything"
            broad = caught in ("everything", "Exception", "BaseException")
            if broad and inside not in CATCHES:
                yield path, node.lineno, f"catches {caught}"


def check_words(path: Path) -> Iterator[Fault]:
    """Find words about the machine or the way that a file was made."""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        for word in PLACES:
            if word in line:
                yield path, number, f"speaks of {word!r}"


def is_kernel(module: str) -> bool:
    """Whether a module holds compiled loops, which only comparisons with slow ones may import."""
    return ".kernels." in module or module.startswith("workbench.geometry")


def check_test_imports() -> Iterator[Fault]:
    """Find modules that tests import and the list does not name, and lines nobody needs."""
    rows = [line.split() for line in INNER_IMPORTS.read_text(encoding="utf-8").splitlines()]
    listed = {row[0]: set(row[1:]) for row in rows if row and row[0] != "#"}
    used: dict[str, set[str]] = {}
    for path in tracked("tests/*.py"):
        for module, node in imported_modules(ast.parse(path.read_text(encoding="utf-8"))):
            if not module.startswith("workbench") or module in PUBLIC:
                continue
            used.setdefault(module, set()).add(path.stem)
            if module not in listed:
                yield path, node.lineno, f"imports {module}: use a public name or a command"
            elif is_kernel(module) and path.stem not in listed[module]:
                yield path, node.lineno, f"imports the kernels of {module} without being listed"
    for number, row in enumerate(rows, start=1):
        idle = (
            row
            and row[0] != "#"
            and (set(row[1:]) - used.get(row[0], set()) or not used.get(row[0]))
        )
        if idle:
            yield INNER_IMPORTS, number, f"{' '.join(row)}: not imported there any more"


def check_scripts() -> Iterator[Fault]:
    """Find imports of the package, in files beside it, of names that are not there: nothing runs
    the scripts of docs and benchmarks day by day."""
    for path in tracked("benchmarks/*.py", "docs/*.py", "tools/*.py"):
        for module, node in imported_modules(ast.parse(path.read_text(encoding="utf-8"))):
            if not module.startswith("workbench.") or not isinstance(node, ast.ImportFrom):
                continue
            room = ROOT / module.replace(".", "/")
            homes = [room.with_suffix(".py"), room / "__init__.py"]
            text = "".join(file.read_text(encoding="utf-8") for file in homes if file.is_file())
            for alias in node.names:
                if not re.search(rf"\b{alias.name}\b", text):
                    yield path, node.lineno, f"{module} has no {alias.name}"


def house_faults() -> list[Fault]:
    """Faults against the rules of the house, file by file."""
    faults: list[Fault] = []
    for path in tracked("workbench/*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        faults += check_imports(path, tree)
        faults += check_definitions(path, tree)
    faults += check_test_imports()
    faults += check_scripts()
    for path in tracked():
        if path.suffix in TEXTS:
            faults += check_words(path)
    return faults


def check_house() -> bool:
    """Print the faults against the rules of the house; True where there is none."""
    faults = house_faults()
    for path, line, what in faults:
        print(f"{path.relative_to(ROOT)}:{line}: {what}")
    return not faults


def run_tool(*arguments: str) -> Callable[[], bool]:
    """A check that is a command; True where it exits with 0."""
    return lambda: subprocess.run([sys.executable, "-m", *arguments], cwd=ROOT).returncode == 0


CHECKS: dict[str, Callable[[], bool]] = {
    "format": run_tool("ruff", "format", "--check", "."),
    "lint": run_tool("ruff", "check", "."),
    "types": run_tool("mypy"),
    "house": check_house,
}


def main(names: list[str]) -> int:
    """Run some checks by name, all where none is named."""
    unknown = [name for name in names if name not in CHECKS]
    if unknown:
        print(f"no check {', '.join(unknown)}; valid: {', '.join(CHECKS)}")
        return 2
    passed = True
    for name in names or CHECKS:
        print(f"{name}:", flush=True)
        passed &= CHECKS[name]()
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
