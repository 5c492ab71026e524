"""The walls of the house: who may import whom, how large things may be, what a light import costs."""

from __future__ import annotations

import ast
import subprocess
import sys

import pytest

from tests.conftest import ROOT, repository_files

PACKAGE = ROOT / "workbench"
FILES = sorted(PACKAGE.rglob("*.py"))
COMMANDS = {"cli_body", "cli_compare", "cli_fit", "cli_motion", "cli_people", "cli_render", "cli_simulate"}
LAYERS = [{"errors"}, {"model"}, {"kernels"}, {"solve", "people", "shape", "files"}, {"dynamics"}, {"study"}, {"draw"},
          {"report", "viewer"}, {"cli_progress"}, COMMANDS, {"cli"}]  # fmt: skip
HOMES = {
    "numba": {"kernels"},
    "llvmlite": {"kernels/compiled.py", "kernels/lanes.py", "kernels/quads.py"},
    "trimesh": {"files/meshes/scene.py"},
    "collada": {"files/meshes/dae.py"},
    "pydantic": {"files"},
    "yaml": {"files"},
    "scipy": {"files", "solve", "shape", "people"},
    "PIL": {"draw"},
    "jinja2": {"report"},
    "markupsafe": {"report"},
    "cyclopts": {"cli.py", *(f"{name}.py" for name in COMMANDS)},
    "rich": {"cli_progress.py"},
    "pyvista": {"draw/window.py"},
    "imageio_ffmpeg": {"draw/films/mp4.py"},
    "manifold3d": {"shape", "files/meshes/parts.py"},
    "mujoco": {"dynamics/mjcf.py"},
    "distributed": {"study/accommodation/cluster.py"},
    "duckdb": {"files/parquet.py"},
}


KEYWORDS = {"cli_body.py", "arguments.py", "compiled.py"}


def imports(path):
    """(module, line) of every import of a file, wherever it stands."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module, node


def room(module):
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else ""


def layer(name):
    return next(i for i, rooms in enumerate(LAYERS) if name in rooms)


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_go_one_way(path):
    here = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    if here in ("__init__", "__main__"):
        return
    for module, _ in imports(path):
        if module.startswith("workbench.") and room(module) != here:
            assert layer(room(module)) < layer(here), f"{here} may not import {module}"


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_every_library_has_one_home(path):
    here = str(path.relative_to(PACKAGE))
    for module, _ in imports(path):
        homes = HOMES.get(module.split(".")[0])
        assert homes is None or any(here == home or here.startswith(home + "/") for home in homes), module


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_nobody_imports_anothers_underscore_name(path):
    for module, node in imports(path):
        if module.startswith("workbench") and isinstance(node, ast.ImportFrom):
            assert not [a.name for a in node.names if a.name.startswith("_") and not a.name.startswith("__")]


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_files_and_functions_keep_to_their_size(path):
    text = path.read_text()
    assert text.count("\n") <= 450
    assert path.stem not in {"utils", "helpers", "common", "misc"}
    most = 60 if "kernels" in path.parts else 40
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            doc = ast.get_docstring(node)
            length = node.end_lineno - node.lineno + 1 - (len(doc.splitlines()) + 1 if doc else 0)
            assert length <= most, f"{node.name}: {length} lines"
            # one flag a measure: the command line is where names come in; decorators hand on what they were called with
            assert node.args.kwarg is None or path.name in KEYWORDS, f"{node.name}: forwards keywords"
        if isinstance(node, ast.ClassDef):
            assert sum(isinstance(n, ast.FunctionDef) for n in node.body) <= 15, node.name
        if isinstance(node, ast.ExceptHandler):
            broad = node.type is None or ast.unparse(node.type) in ("Exception", "BaseException")
            assert not broad or path.name == "cli.py"  # it makes one line and an exit code of what nobody expects


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_every_public_function_is_documented(path):
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
            assert ast.get_docstring(node), node.name


def loaded_by(code):
    """Names of the top-level modules that a fresh Python has loaded after running some code."""
    script = f"import sys\n{code}\nprint(*sorted({{m.split('.')[0] for m in sys.modules}}))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())


def test_importing_the_workbench_loads_no_library_at_all():
    assert not loaded_by("import workbench") & set(HOMES)


def test_help_loads_neither_compiler_nor_mesh_library():
    code = "from workbench.cli import main\nimport contextlib, io\n"
    code += "with contextlib.redirect_stdout(io.StringIO()): main(['--help'])"
    assert not loaded_by(code) & {"numba", "scipy", "trimesh", "pyvista", "PIL", "pydantic", "jinja2", "numpy"}


def test_no_file_speaks_of_the_place_it_was_made_in():
    words = ["/wo" + "rk/", "is" + "sue #", "sess" + "ion ends"]
    here = [p for p in repository_files() if p.suffix in {".py", ".md", ".yaml", ".toml", ".cff", ".j2"}]
    assert len(here) > 300
    assert not [(p.name, w) for p in here for w in words if w in p.read_text()]


def test_a_stray_folder_in_a_checkout_is_not_the_repositorys(tmp_path):
    for name in ("workbench/a.py", "venv2/lib/b.py", ".tox/c.md"):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text("")
    assert repository_files(tmp_path) == (tmp_path / "workbench" / "a.py",)
    for command in (["init", "-q"], ["add", "workbench", ".tox"]):
        subprocess.run(["git", *command], cwd=tmp_path, check=True, capture_output=True)
    repository_files.cache_clear()
    assert repository_files(tmp_path) == (tmp_path / ".tox" / "c.md", tmp_path / "workbench" / "a.py")


def test_every_public_name_is_where_the_package_looks_for_it():
    import workbench

    for name in workbench.__all__:
        assert getattr(workbench, name) is not None, name
