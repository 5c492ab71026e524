"""The package as it is installed: what sdist and wheel hold, and that an installed one runs in
another folder."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig

import pytest

from tests.conftest import ROOT, repository_files

DATA = ("bodies", "environments", "studies")
IMPORT_ALL = """
import importlib, pkgutil, workbench
for module in pkgutil.walk_packages(workbench.__path__, "workbench."):
    if module.name != "workbench.__main__":
        importlib.import_module(module.name)
print(workbench.__file__)
"""


@pytest.fixture(scope="module")
def builders():
    """What makes the sdist and the wheel of this project."""
    pytest.importorskip(
        "hatchling", reason="hatchling is not installed: pip install 'bubbleman-workbench[dev]'"
    )
    from hatchling.builders.sdist import SdistBuilder
    from hatchling.builders.wheel import WheelBuilder

    return SdistBuilder(str(ROOT)), WheelBuilder(str(ROOT))


def names_of(builder):
    """Where the files go in the archive, by where they are in the repository."""
    found = {file.path: file.distribution_path for file in builder.recurse_included_files()}
    return {os.path.relpath(path, ROOT).replace(os.sep, "/"): name for path, name in found.items()}


def repository_names():
    return {path.relative_to(ROOT).as_posix() for path in repository_files()}


def test_the_sdist_holds_all_that_is_tracked_and_no_other_folder_of_the_checkout(
    builders, tmp_path
):
    held = set(names_of(builders[0]))
    tracked = repository_names()
    assert tracked - held <= {"README.md", "LICENSE", "pyproject.toml", ".gitignore"}
    assert {name.split("/")[0] for name in held} <= {name.split("/")[0] for name in tracked}


def test_the_sdist_takes_what_the_metadata_names_from_elsewhere(builders):
    metadata = builders[0].metadata.core
    assert metadata.readme_path == "README.md" and metadata.license_files == ["LICENSE"]


def test_the_wheel_holds_the_package_and_the_catalogue_as_its_data(builders):
    held = names_of(builders[1])
    for name in repository_names():
        folder = name.split("/")[0]
        if folder == "workbench" or folder in DATA:
            assert held.pop(name) == (name if folder == "workbench" else f"workbench/data/{name}")
    assert not [name for name in held if not name.startswith(("workbench/", *DATA))]


@pytest.fixture(scope="module")
def archives(builders, tmp_path_factory):
    """An sdist, and a wheel that is made of that sdist, unpacked elsewhere: it must hold all that
    the wheel needs."""
    out = tmp_path_factory.mktemp("dist")
    run([sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", out], cwd=ROOT)
    (sdist,) = out.glob("*.tar.gz")
    run([sys.executable, "-m", "pip", "wheel", *OFFLINE, "-w", out, sdist], cwd=out)
    (wheel,) = out.glob("*.whl")
    return {"sdist": sdist, "wheel": wheel}


OFFLINE = (
    "--quiet",
    "--disable-pip-version-check",
    "--no-deps",
    "--no-build-isolation",
    "--no-index",
)


def run(command, *, cwd, **variables):
    """Run a command, with what it printed in the message where it fails; returns what it
    printed."""
    env = os.environ | {"PYTHONPATH": "", "WORKBENCH_CACHE": "off"} | variables
    done = subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True)
    assert done.returncode == 0, f"{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    return done.stdout


@pytest.mark.nightly
@pytest.mark.parametrize("kind", ["sdist", "wheel"])
def test_an_installed_package_runs_a_shipped_study_by_name_from_another_folder(
    archives, kind, tmp_path
):
    site = tmp_path / "site"
    run(
        [sys.executable, "-m", "pip", "install", *OFFLINE, "--target", site, archives[kind]],
        cwd=tmp_path,
    )
    path = os.pathsep.join([str(site), sysconfig.get_path("purelib")])
    where = run([sys.executable, "-W", "error", "-c", IMPORT_ALL], cwd=tmp_path, PYTHONPATH=path)
    assert where.startswith(str(site))
    command = [sys.executable, site / "bin" / "workbench", "run", "trainer_clearance"]
    assert "report.html" in run(command, cwd=tmp_path, PYTHONPATH=path)
    assert (tmp_path / "out" / "trainer_clearance" / "report.html").is_file()


@pytest.mark.nightly
@pytest.mark.parametrize("version", ["3.12", "3.13"])
def test_a_newer_python_imports_all_modules_and_runs_a_study_with_warnings_as_errors(
    archives, version, tmp_path
):
    python = f"python{version}"
    try:
        subprocess.run([python, "-m", "venv", tmp_path / "venv"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip(f"{python} is not on PATH, or cannot make an environment")
    inside = tmp_path / "venv" / "bin" / "python"
    pip = [inside, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    if subprocess.run([*pip, "hatchling"], cwd=tmp_path, capture_output=True).returncode:
        pytest.skip("no package registry can be reached")
    run([*pip, archives["wheel"]], cwd=tmp_path)
    run([inside, "-W", "error", "-c", IMPORT_ALL], cwd=tmp_path)
    run([inside, "-W", "error", "-m", "workbench", "run", "trainer_clearance"], cwd=tmp_path)
    assert (tmp_path / "out" / "trainer_clearance" / "result.json").is_file()
