"""Write the figures of the documents that come from shipped studies, or check that they are still true.

    python tools/docs_figures.py                     # run the studies and write what they say
    python tools/docs_figures.py --check docs/driving.md

A figure stands between two comments:

    <!-- studies/car_driver.yaml: headline -->
    82 % of the population fits ...
    <!-- end -->

Each study is run once. What is written is what a run says:

- `headline`: the sentences at the top of the report.
- `verdicts`: a line for each criterion, as on the command line.
- `groups`: the share of each group of people with its interval.
- `changes`: what each change of the study would gain.

The exit code is 1 where a document differs and `--check` was given.
"""

from __future__ import annotations

import re
import sys
import textwrap
from collections.abc import Callable
from functools import cache
from pathlib import Path

import workbench as wb
from workbench.files.results.result import ResultFile
from workbench.model.result import Result
from workbench.report.folder import report_lines
from workbench.report.population.rows import population_lines
from workbench.report.result_rows import result_file

ROOT = Path(__file__).resolve().parents[1]
FIGURE = re.compile(r"(<!-- (studies/\S+): (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
WIDTH = 120


def headline(result: Result, rows: ResultFile) -> list[str]:
    """The sentences at the top of the report."""
    return textwrap.wrap(rows.headline, WIDTH)


def verdicts(result: Result, rows: ResultFile) -> list[str]:
    """A line of a list for each criterion."""
    lines = (line for line in report_lines(result, rows) if line.startswith(("passed", "FAILED")))
    return [part for line in lines for part in _listed(" ".join(line.split()))]


def groups(result: Result, rows: ResultFile) -> list[str]:
    """A line of a list for each group of people."""
    assert rows.population is not None
    names = {group.group for group in rows.population.shares}
    lines = population_lines(result.population) if result.population is not None else []
    return [f"- {line.strip()}" for line in lines if any(f": {name} (" in line for name in names)]


def changes(result: Result, rows: ResultFile) -> list[str]:
    """A line of a list for each change that was tried."""
    lines = population_lines(result.population) if result.population is not None else []
    return [part for line in lines if " % " in line and " from " in line for part in _listed(line)]


KINDS: dict[str, Callable[[Result, ResultFile], list[str]]] = {
    "headline": headline,
    "verdicts": verdicts,
    "groups": groups,
    "changes": changes,
}


def _listed(line: str) -> list[str]:
    return textwrap.wrap(f"- {line}", WIDTH, subsequent_indent="  ")


@cache
def found(study: str) -> tuple[Result, ResultFile]:
    """A study that was run, and its rows."""
    result = wb.run(wb.load_study(ROOT / study))
    return result, result_file(result)


def written(text: str) -> str:
    """A document with its figures as they are now."""

    def figure(match: re.Match[str]) -> str:
        lines = KINDS[match[3]](*found(match[2]))
        return "\n".join([match[1].rstrip("\n"), *lines, match[4]])

    return FIGURE.sub(figure, text)


def main(arguments: list[str]) -> int:
    """Write the documents, or say which differ."""
    check = "--check" in arguments
    paths = [Path(name) for name in arguments if name != "--check"]
    differ = 0
    for path in paths or sorted((ROOT / "docs").glob("*.md")):
        before = path.read_text(encoding="utf-8")
        after = written(before)
        if after == before:
            continue
        differ += 1
        print(f"{path}: {'differs from a run' if check else 'written'}")
        if not check:
            path.write_text(after, encoding="utf-8")
    return 1 if check and differ else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
