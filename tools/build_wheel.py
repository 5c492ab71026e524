"""Build a wheel that brings machine code along, so that the first run after installing is a warm one.

`python tools/build_wheel.py [--out dist] [STUDY ...]` runs studies of the catalogue, all where none
is named, with a compiler that knows no more of the processor than its level x86-64-v3 (Haswell,
Zen and later). What it compiles goes into the wheel. Installed, it is used where Python's minor
version, numba, llvmlite, numpy's minor version and the code itself are those of the build; anything
else is compiled as ever, and no answer depends on it.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from workbench.compiled_linked import LEVEL, LEVEL_FEATURES, SHIPPED

ROOT = Path(__file__).parents[1]
SOURCES = (
    "workbench",
    "bodies",
    "environments",
    "studies",
    "pyproject.toml",
    "README.md",
    "LICENSE",
)
FAILED_CRITERION = 1
"""Exit code of a run that did what it should."""


def main() -> None:
    """Build the wheel, and say where it is and what it brings."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "studies", nargs="*", default=sorted(p.stem for p in ROOT.glob("studies/*.yaml"))
    )
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        print(build(Path(place), given.studies, given.out))


def build(place: Path, studies: list[str], out: Path) -> str:
    """Compile in an empty folder `place`, and return a line on the wheel that is left in `out`."""
    tree = place / "tree"
    tree.mkdir()
    for name in SOURCES:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tree / name)
    kept = place / "kept"
    compiling = {
        "NUMBA_CACHE_DIR": str(kept),
        "NUMBA_CPU_NAME": LEVEL,
        "NUMBA_CPU_FEATURES": LEVEL_FEATURES,
        "PYTHONPATH": str(tree),
    }
    for study in studies:
        command = [sys.executable, "-m", "workbench", "run", study, "--out", str(place / study)]
        done = subprocess.run(command, env=os.environ | compiling, cwd=place, check=False)
        if done.returncode not in (0, FAILED_CRITERION):
            sys.exit(f"{study}: exit code {done.returncode}")
    brought = tree / "workbench" / SHIPPED.name
    brought.mkdir()
    for file in sorted(kept.rglob("*.nbc")):
        if (brought / file.name).exists():
            sys.exit(f"two kernels are called {file.name.partition('.py')[0]}: rename one")
        shutil.copy(file, brought)
    wheel = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(out)]
    subprocess.run([*wheel, str(tree)], check=True)
    files = list(brought.iterdir())
    size = sum(file.stat().st_size for file in files) / 1e6
    return f"{out}: machine code of {len(files)} kernels, {size:.1f} MB, for {LEVEL} and later"


if __name__ == "__main__":
    main()
