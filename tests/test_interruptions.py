"""What nobody expects ends with one line and an exit code of its own: faults of the program, Ctrl-C
at any time."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress

import numpy as np
import pytest

from tests.conftest import ROOT
from tests.toy_cockpit import write_toy
from workbench.cli import application, main

ASK = "Please report this with the command and its files. WORKBENCH_TRACEBACK=1 shows where it happened.\n"


def failing(monkeypatch, error):
    """`workbench doctor` with a fault in it."""

    def fail():
        raise error

    monkeypatch.setattr("workbench.report.diagnostics.doctor_report", fail)
    return main(["doctor"])


@pytest.mark.parametrize(
    "error", [TypeError("no\nlen()"), KeyError("x"), AssertionError(), IndexError()]
)
def test_an_internal_error_is_70_with_a_line_that_asks_to_report_it(monkeypatch, capsys, error):
    assert failing(monkeypatch, error) == 70
    out, err = capsys.readouterr()
    assert out == ""
    told = f"internal error: {type(error).__name__} in test_interruptions.py, line "
    assert err.startswith(told) and err.endswith(ASK) and err.count("\n") == 2


def test_the_traceback_of_an_internal_error_is_shown_where_it_is_asked_for(monkeypatch, capsys):
    monkeypatch.setenv("WORKBENCH_TRACEBACK", "1")
    assert failing(monkeypatch, TypeError("x")) == 70
    told = capsys.readouterr().err
    assert told.startswith("Traceback (most recent call last):") and told.endswith(ASK)


def test_endless_nesting_and_a_full_memory_are_told_in_words(monkeypatch, capsys):
    assert failing(monkeypatch, RecursionError("maximum recursion depth exceeded")) == 70
    assert (
        "an input is nested too deeply, or the workbench calls itself without end"
        in capsys.readouterr().err
    )
    with pytest.raises(MemoryError) as full:
        np.empty(2**55, dtype=np.float64)
    assert failing(monkeypatch, full.value) == 3
    told = capsys.readouterr().err
    assert (
        told.startswith("out of memory (Unable to allocate 256. PiB")
        and "give fewer people" in told
    )


def test_an_error_that_came_of_an_interruption_is_told_as_one(monkeypatch, capsys):
    error = ImportError("numpy could not be imported")
    error.__cause__ = KeyboardInterrupt()
    assert failing(monkeypatch, error) == 130
    assert capsys.readouterr().err == "stopped\n"


def interrupted(delay, *arguments):
    """Exit code and stderr of a command that gets Ctrl-C, as all its children do, after so many
    seconds."""
    command = [sys.executable, "-m", "workbench", *map(str, arguments)]
    process = subprocess.Popen(
        command,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    time.sleep(delay)
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGINT)
    _, told = process.communicate(timeout=600)
    return process.returncode, told


def test_nothing_is_imported_before_ctrl_c_is_understood():
    code = "import sys; before = set(sys.modules); import workbench.__main__; print(*sorted(set(sys.modules) - before))"
    done = subprocess.run(
        [sys.executable, "-S", "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    of_python = {
        "os",
        "os.path",
        "posixpath",
        "genericpath",
        "stat",
        "_stat",
        "abc",
        "_abc",
        "_collections_abc",
    }
    assert set(done.stdout.split()) - of_python <= {
        "__future__",
        "_signal",
        "workbench",
        "workbench.__main__",
    }


def test_ctrl_c_while_the_command_line_is_imported_is_130_with_one_line():
    code = "import os, signal, sys\n"
    code += "class Finder:\n"
    code += "    def find_spec(self, name, *_):\n"
    code += "        if name == 'cyclopts': os.kill(os.getpid(), signal.SIGINT)\n"
    code += "sys.meta_path.insert(0, Finder())\n"
    code += "from workbench.__main__ import main\nsys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", code, "doctor"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "stopped\n")


@pytest.mark.parametrize("module", ["numpy", "pydantic", "workbench.report.folder"])
def test_ctrl_c_while_a_command_imports_its_libraries_is_130_with_one_line(tmp_path, module):
    code = "import os, signal, sys\n"
    code += "class Finder:\n"
    code += "    def find_spec(self, name, *_):\n"
    code += f"        if name == {module!r}: os.kill(os.getpid(), signal.SIGINT)\n"
    code += "sys.meta_path.insert(0, Finder())\n"
    code += "from workbench.__main__ import main\nsys.exit(main())"
    words = [sys.executable, "-c", code, "run", "trainer_clearance", "--out", str(tmp_path / "out")]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "stopped\n")
    assert not list(tmp_path.iterdir())


def test_an_ignored_ctrl_c_stays_ignored():
    code = "import os, signal; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
    code += "from workbench.__main__ import main; code = main()\n"
    code += "assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN; raise SystemExit(code)"
    done = subprocess.run(
        [sys.executable, "-c", code, "--version"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.nightly
def test_ctrl_c_at_any_time_leaves_no_traceback(tmp_path):
    """At 100 times from the first import on; on a busy machine Python itself may still be starting
    then, and says so."""
    codes = set()
    for delay in np.linspace(0.03, 3.0, 100):
        code, told = interrupted(delay, "run", "trainer_clearance", "--out", str(tmp_path / "out"))
        if delay < 0.2 and "Traceback" in told and "/workbench/" not in told:
            continue
        assert "Traceback" not in told and told in ("", "stopped\n"), (delay, told)
        assert code in (0, 130, -signal.SIGINT), delay
        codes.add(code)
    assert 130 in codes


@pytest.mark.nightly
def test_ctrl_c_while_bodies_are_fitted_by_several_processes_leaves_no_traceback(tmp_path):
    path = write_toy(tmp_path, people=64 * 3)
    for delay in np.linspace(0.5, 8.0, 40):
        code, told = interrupted(delay, "run", path, "--out", tmp_path / "out")
        done = code in (0, -signal.SIGINT) and "stopped" not in told
        stopped = code == 130 and told.splitlines()[-1].startswith("stopped")
        assert (done or stopped) and "Traceback" not in told, (delay, code, told)


def test_the_exit_codes_of_the_program_and_of_its_help_are_the_same(capsys):
    assert (getattr(os, "EX_SOFTWARE", 70), 130) == (
        application.INTERNAL_ERROR,
        application.INTERRUPTED,
    )
    assert main(["--help"]) == 0
    assert "70 an internal error, 130 stopped by Ctrl-C" in " ".join(
        capsys.readouterr().out.split()
    )
