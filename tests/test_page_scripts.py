"""The scripts of pages, read and tried by Node, which comes with Playwright."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ROOT
from workbench.live.protocol import packed

VIEW = ROOT / "workbench" / "draw" / "web"
PAGE = ROOT / "workbench" / "live" / "page"
REPORT = ROOT / "workbench" / "report"
SCRIPTS = sorted([*VIEW.glob("*.js"), *PAGE.glob("*.js"), *REPORT.glob("*.js")])


def node():
    """Where Node is; the tests are skipped where it is not."""
    try:
        import playwright

        bundled = Path(playwright.__file__).parent / "driver" / "node"
    except ImportError:
        bundled = Path("none")
    found = str(bundled) if bundled.exists() else shutil.which("node")
    if found is None:
        pytest.skip("there is no Node to read the scripts: pip install playwright")
    return found


def done(*command, folder=None, given=None):
    found = subprocess.run(
        command, cwd=folder, input=given, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stdout + found.stderr


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_every_script_is_read_by_node(path):
    done(node(), "--check", "--input-type=module", "-", given=path.read_text())


def test_the_units_of_the_scripts_pass(tmp_path):
    program = node()
    for name, folder in (("view", VIEW), ("page", PAGE)):
        (tmp_path / name).mkdir()
        for path in folder.glob("*.js"):
            text = path.read_text().replace('"/view/', '"../view/')
            (tmp_path / name / path.name).write_text(text)
    (tmp_path / "package.json").write_text('{"type": "module"}')
    arrays = [
        ("a", np.array([0.5, -1.25, 4096], dtype=np.float32)),
        ("b", np.array([0, 65535, 258], dtype=np.uint16)),
        ("c", np.array([-1, 70000], dtype=np.int32)),
    ]
    (tmp_path / "answer.bin").write_bytes(packed({"kind": "answer – ß"}, arrays))
    shutil.copy(ROOT / "tests" / "page_units.mjs", tmp_path)
    done(program, "--test", "page_units.mjs", folder=tmp_path)
