"""A study that is run and its report written into a folder: what `workbench run` does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from workbench.files.output_folder import check_folder
from workbench.files.results.result import ResultFile
from workbench.files.study.reader import load_study
from workbench.report.folder import report_lines, write_report
from workbench.report.sentences import in_words
from workbench.study.run import check_run, run

__all__ = ["Written", "run_and_write"]


@dataclass(frozen=True, eq=False)
class Written:
    """A report that was written: its folder, the rows of result.json, whether all criteria hold, and
    in words the warnings and what the command line says before the headline."""

    folder: Path
    rows: ResultFile
    passed: bool
    warnings: tuple[str, ...]
    lines: tuple[str, ...]

    @property
    def headline(self) -> str:
        """The first sentence."""
        return self.rows.headline


def run_and_write(
    source: str,
    out: Path | None = None,
    *,
    film: bool = False,
    cluster: str | None = None,
    say: Callable[[str], None] = lambda text: None,
) -> Written:
    """Run a study and write its report.

    Parameters
    ----------
    source
        A study file, or the name of one that comes with the workbench.
    out
        The folder to write; out/STUDY, from where the program runs, if None.
    film
        Whether a film of the motions is made.
    cluster
        As of `workbench.study.run.run`.
    say
        Called with words on how far it is.

    Raises
    ------
    WorkbenchError
        As of `load_study`, `run` and `write_report`.
    """
    kept: list[str] = []
    if out is not None:
        check_folder(out, holds="result")  # before the work, not after it
    loaded = load_study(source)
    check_run(loaded, cluster=cluster, film=film)
    folder = out or Path("out") / loaded.name
    place = check_folder(folder, holds="result")  # again, now that all inputs are known
    say("measuring")
    keep = place.with_name(f".{place.name}.chunks")
    result = run(loaded, keep=keep, say=say, cluster=cluster)
    rows = write_report(result, folder, film=film, progress=say, tell=kept.append)
    if loaded.crowd is not None:
        from workbench.study.accommodation.checkpoints import forget_chunks

        forget_chunks(keep)
    warnings = (*kept, *map(in_words, rows.warnings))
    return Written(folder, rows, result.passed, warnings, tuple(report_lines(result, rows)))
