"""The house from outside: what a light import costs, and that its checks find what they look for."""

from __future__ import annotations

import ast
import subprocess
import sys
from importlib import import_module
from types import SimpleNamespace

import pytest

from tests.conftest import (
    ABSENT,
    CORE,
    FIRST,
    ROOT,
    pytest_terminal_summary,
    real_input,
    repository_files,
)
from tools import check


def loaded_by(code):
    """Names of the top-level modules that a fresh Python has loaded after running some code."""
    script = f"import sys\n{code}\nprint(*sorted({{m.split('.')[0] for m in sys.modules}}))"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return set(done.stdout.splitlines()[-1].split())


def test_importing_the_workbench_loads_no_library_at_all():
    assert not loaded_by("import workbench") & set(check.HOMES)


def test_help_loads_neither_compiler_nor_mesh_library():
    code = "from workbench.cli import main\nimport contextlib, io\n"
    code += "with contextlib.redirect_stdout(io.StringIO()): main(['--help'])"
    assert not loaded_by(code) & {
        "numba",
        "scipy",
        "trimesh",
        "pyvista",
        "PIL",
        "pydantic",
        "jinja2",
        "numpy",
        "anywidget",
    }


FAULTS = [
    ("import workbench.report.page", "motion", "may not import"),
    ("import yaml", "motion", "is at home in files"),
    ("from workbench.model.body import _x", "motion", "a private name"),
    ("def f(**options):\n    'Do it.'", "motion", "forwards keywords"),
    ("def f():\n    pass", "motion", "has no docstring"),
    ("try:\n    x = 1\nexcept Exception:\n    x = 2", "motion", "catches Exception"),
]


@pytest.mark.parametrize(("text", "room", "found"), FAULTS)
def test_the_house_check_finds_each_kind_of_fault(text, room, found):
    path = check.PACKAGE / room / "made_up.py"
    tree = ast.parse(text)
    faults = [*check.check_imports(path, tree), *check.check_definitions(path, tree)]
    assert [what for _, _, what in faults if found in what], faults


def test_the_house_check_finds_words_about_a_machine(tmp_path):
    path = tmp_path / "a.md"
    path.write_text("fine\nsee /wo" + "rk/main\n")
    assert [line for _, line, _ in check.check_words(path)] == [2]


@pytest.mark.parametrize(
    ("text", "listed", "found"),
    [
        ("from workbench import place", "", []),
        ("from workbench.draw.camera import Camera", "workbench.draw.camera", []),
        ("from workbench.draw.camera import Camera", "", ["use a public name"]),
        (
            "import workbench.geometry.nearest",
            "workbench.geometry.nearest test_b",
            ["kernels", "any more"],
        ),
        ("", "workbench.draw.camera", ["not imported there any more"]),
    ],
)
def test_the_house_check_finds_tests_that_reach_inside(tmp_path, monkeypatch, text, listed, found):
    (tmp_path / "test_a.py").write_text(text)
    (tmp_path / "listed.txt").write_text(f"# a comment\n{listed}\n")
    monkeypatch.setattr(check, "tracked", lambda *patterns: [tmp_path / "test_a.py"])
    monkeypatch.setattr(check, "INNER_IMPORTS", tmp_path / "listed.txt")
    faults = [what for _, _, what in check.check_test_imports()]
    assert len(faults) == len(found)
    assert all(part in what for part, what in zip(found, faults, strict=True))


def test_the_house_check_finds_scripts_that_import_what_is_gone(tmp_path, monkeypatch):
    (tmp_path / "make.py").write_text(
        "from workbench.draw.camera import Camera, Gone\nfrom workbench.no_more import Camera\n"
        "from workbench.cli import main\n"
    )
    monkeypatch.setattr(check, "tracked", lambda *patterns: [tmp_path / "make.py"])
    assert [line for _, line, _ in check.check_scripts()] == [1, 2]


def test_a_stray_folder_in_a_checkout_is_not_the_repositorys(tmp_path):
    for name in ("workbench/a.py", "venv2/lib/b.py", ".tox/c.md"):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text("")
    assert repository_files(tmp_path) == (tmp_path / "workbench" / "a.py",)
    for command in (["init", "-q"], ["add", "workbench", ".tox"]):
        subprocess.run(["git", *command], cwd=tmp_path, check=True, capture_output=True)
    repository_files.cache_clear()
    assert repository_files(tmp_path) == (
        tmp_path / ".tox" / "c.md",
        tmp_path / "workbench" / "a.py",
    )


def test_every_public_name_is_where_the_package_looks_for_it():
    import workbench

    for name in workbench.__all__:
        assert getattr(workbench, name) is not None, name


def test_what_nouns_look_up_by_name_is_there():
    found = [
        (call.args[0].value, call.args[1].value)
        for path in (ROOT / "workbench" / "model").glob("*.py")
        for call in ast.walk(ast.parse(path.read_text()))
        if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "above"
    ]
    assert len(found) > 5
    for module, name in found:
        assert hasattr(import_module(f"workbench.{module}"), name), (module, name)


def test_the_tiers_name_modules_that_are_there():
    modules = {path.stem for path in repository_files() if path.parent.name == "tests"}
    assert modules >= CORE | set(FIRST)


def test_tests_without_their_real_inputs_are_skipped_and_counted(tmp_path):
    with pytest.raises(pytest.skip.Exception, match=ABSENT) as skipped:
        real_input(tmp_path / "gone.obj")
    report = SimpleNamespace(longrepr=("a.py", 1, str(skipped.value)))
    other = SimpleNamespace(longrepr=("a.py", 1, "no users here"))
    lines = []
    reporter = SimpleNamespace(stats={"skipped": [report, other, report]}, write_line=lines.append)
    pytest_terminal_summary(reporter)
    assert len(lines) == 1 and lines[0].startswith("2 tests were skipped: real inputs are absent")
