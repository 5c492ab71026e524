"""Compiled code that is kept is believed only where it is whole and made from these kernels."""

from __future__ import annotations

import cProfile
import importlib.util
import os
import pickle
import re
import subprocess
import sys
import zipfile

import pytest
from numba.core.config import reload_config
from numba.core.registry import CPUDispatcher

from tests.conftest import ROOT, tracked
from tests.test_index_cache import DAMAGE
from workbench import compiled, compiled_linked
from workbench.compiled import TESTED, why_plain
from workbench.compiled_linked import code_stamp

KERNEL = """
from workbench.compiled import njit

@njit(cache=True)
def doubled(x):
    return 2 * x
"""


@pytest.fixture
def kernel(tmp_path, monkeypatch):
    """A function that compiles a small kernel anew, as a new process does, and hands it back."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    # else the compiler looks at the environment only after it has chosen the first folder
    reload_config()
    path = tmp_path / "small_kernel.py"

    def fresh(write=True):
        if write:
            path.write_text(KERNEL)
        spec = importlib.util.spec_from_file_location("small_kernel", path)
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "small_kernel", module)
        spec.loader.exec_module(module)
        return module.doubled

    return fresh


def files(folder, ending):
    return sorted((folder / "__pycache__").glob(f"*.{ending}"))


def compiled_anew(kernel):
    """Whether the next process compiles the kernel; it gives the right answer either way."""
    doubled = kernel()
    assert doubled(21) == 42
    stats = doubled.stats
    assert sum(stats.cache_hits.values()) + sum(stats.cache_misses.values()) == 1
    return not stats.cache_hits


def test_what_was_compiled_once_is_read_the_next_time(kernel, tmp_path):
    assert compiled_anew(kernel) and not compiled_anew(kernel)
    assert len(files(tmp_path, "nbc")) == 1


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_file_is_compiled_and_kept_again(kernel, tmp_path, damage):
    compiled_anew(kernel)
    path = files(tmp_path, "nbc")[0]
    whole = path.read_bytes()
    path.write_bytes(DAMAGE[damage](whole))
    assert compiled_anew(kernel) and not compiled_anew(kernel)
    # the compiler numbers what it compiles, so that a number may have a digit more
    assert abs(len(path.read_bytes()) - len(whole)) < 64


def test_a_file_that_is_gone_or_is_a_folder_stops_nothing(kernel, tmp_path):
    compiled_anew(kernel)
    path = files(tmp_path, "nbc")[0]
    path.unlink()
    assert compiled_anew(kernel) and not compiled_anew(kernel)
    path.unlink()
    path.mkdir()
    assert compiled_anew(kernel) and compiled_anew(kernel)


def test_the_code_for_other_arguments_is_not_believed(kernel, tmp_path):
    for argument in (21, 21.5):
        kernel()(argument)
    first, second = files(tmp_path, "nbc")
    first.write_bytes(second.read_bytes())
    assert kernel()(21) == 42 and kernel()(21.5) == 43.0


def test_two_processes_that_keep_code_at_once_lose_nothing(kernel, monkeypatch):
    """One keeps code for other arguments while the other is about to write; both are read later."""
    write = compiled_linked._Files._write
    other = kernel()

    def interrupted(files, path, held):
        monkeypatch.setattr(compiled_linked._Files, "_write", write)
        assert other(21.5) == 43.0
        write(files, path, held)

    monkeypatch.setattr(compiled_linked._Files, "_write", interrupted)
    assert kernel()(21) == 42
    again = kernel()
    assert again(21.5) == 43.0 and again(21) == 42
    assert not again.stats.cache_misses


def test_a_file_of_the_compiler_itself_is_not_read(kernel, tmp_path):
    compiled_anew(kernel)
    files(tmp_path, "nbc")[0].write_bytes(pickle.dumps("0.0") + pickle.dumps(("stamp", {})))
    assert compiled_anew(kernel)


TWO_FILES = {
    "callee.py": """
from workbench.compiled import njit

FACTOR = 2

@njit(cache=True, forceinline=True)
def times(x):
    return FACTOR * x
""",
    "small_kernel.py": """
from callee import times
from workbench.compiled import njit

@njit(cache=True)
def middle(x):
    return times(x)

@njit(cache=True)
def doubled(x):
    return middle(x)

@njit(cache=True)
def other(x):
    return 2 * x
""",
}


@pytest.fixture
def two_files(kernel, tmp_path, monkeypatch):
    """Write two files of kernels and run two entries as a new process does.

    Returns their answers for 21, and whether each was compiled anew.
    """
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def fresh(change=str):
        for name, text in TWO_FILES.items():
            (tmp_path / name).write_text(change(text))
        monkeypatch.delitem(sys.modules, "callee", raising=False)
        importlib.invalidate_caches()
        kernel(write=False)
        module = sys.modules["small_kernel"]
        answers = module.doubled(21), module.other(21)
        return answers, [not each.stats.cache_hits for each in (module.doubled, module.other)]

    return fresh


def test_a_change_two_calls_away_recompiles_the_entry_that_calls_and_no_other(two_files):
    assert two_files() == ((42, 42), [True, True])
    assert two_files() == ((42, 42), [False, False])
    changed = two_files(lambda text: text.replace("return FACTOR * x", "return FACTOR * x + 1"))
    assert changed == ((43, 42), [True, False])
    assert two_files() == ((42, 42), [True, False])


def test_a_change_of_a_constant_or_an_option_of_a_callee_recompiles(two_files):
    assert two_files()[1] == [True, True]
    changed = two_files(lambda text: text.replace("FACTOR = 2", "FACTOR = 20"))
    assert changed == ((420, 42), [True, False])
    changed = two_files(lambda text: text.replace(", forceinline=True", ""))
    assert changed == ((42, 42), [True, False])


def test_a_comment_a_docstring_or_a_line_above_recompiles_nothing(two_files):
    def documented(text):
        return text.replace("(x):\n", '(x):\n    """Say something."""\n')

    assert two_files(documented)[1] == [True, True]
    changes = [
        lambda text: documented(text).replace("something", "something else"),
        lambda text: "# a comment\n\n" + documented(text),
        lambda text: documented(text).replace("    return", "    # a comment\n    return"),
    ]
    for change in changes:
        assert two_files(change) == ((42, 42), [False, False])


def test_another_compiler_or_another_file_of_vector_instructions_recompiles(
    kernel, tmp_path, monkeypatch
):
    assert compiled_anew(kernel) and not compiled_anew(kernel)
    folder = tmp_path / "package"
    for name in compiled_linked.WHOLE_FILES:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("one = 1\n")
    monkeypatch.setattr(compiled_linked, "PACKAGE", folder)
    try:
        for name in compiled_linked.WHOLE_FILES:
            (folder / name).write_text("one = 11\n")
            compiled_linked._compiler_stamp.cache_clear()
            assert compiled_anew(kernel) and not compiled_anew(kernel)
        monkeypatch.setattr(compiled_linked, "_versions", lambda: ["another compiler"])
        compiled_linked._compiler_stamp.cache_clear()
        assert compiled_anew(kernel)
    finally:
        compiled_linked._compiler_stamp.cache_clear()


def test_what_runs_under_a_profiler_is_compiled_as_it_was(kernel):
    doubled = kernel()
    before = code_stamp(doubled)
    assert cProfile.Profile().runcall(doubled, 21) == 42
    assert code_stamp(doubled) == before


def test_machine_code_of_a_wheel_is_used_where_nothing_is_kept(kernel, tmp_path, monkeypatch):
    kernel()
    elsewhere = tmp_path / "elsewhere"
    level = {
        "NUMBA_CACHE_DIR": str(elsewhere),
        "NUMBA_CPU_NAME": compiled_linked.LEVEL,
        "NUMBA_CPU_FEATURES": compiled_linked.LEVEL_FEATURES,
        "PYTHONPATH": os.pathsep.join([str(ROOT), str(tmp_path)]),
    }
    call = "import small_kernel; small_kernel.doubled(21)"
    subprocess.run([sys.executable, "-c", call], env=os.environ | level, check=True)
    (made,) = elsewhere.rglob("*.nbc")
    monkeypatch.setattr(compiled_linked, "SHIPPED", made.parent)
    features = CPUDispatcher(lambda: 0).targetctx.codegen().magic_tuple()[2].split(",")
    if not set(compiled_linked.LEVEL_FEATURES.split(",")) <= set(features):
        pytest.skip("this processor is below the level that wheels are made for")
    assert not compiled_anew(kernel) and not files(tmp_path, "nbc")
    made.write_bytes(made.read_bytes()[:-1] + b"?")
    assert compiled_anew(kernel) and files(tmp_path, "nbc")


@pytest.mark.nightly
def test_the_first_run_of_an_installed_wheel_with_machine_code_compiles_nothing(tmp_path):
    build = [sys.executable, str(ROOT / "tools" / "build_wheel.py"), "--out", str(tmp_path)]
    subprocess.run([*build, "wheelchair_counter"], check=True)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "installed")
    fresh = {
        "NUMBA_CACHE_DIR": str(tmp_path / "kept"),
        "PYTHONPATH": str(tmp_path / "installed"),
    }
    run = [sys.executable, "-m", "workbench", "run", "wheelchair_counter", "--out", "result"]
    subprocess.run(run, env=os.environ | fresh, cwd=tmp_path, check=True)
    assert not list((tmp_path / "kept").rglob("*.nbc"))


def test_what_cannot_be_described_is_refused():
    table = {}

    def reads():
        return table

    with pytest.raises(TypeError, match="contents cannot be told"):
        code_stamp(reads)


def test_a_function_may_be_called_by_python_and_by_compiled_code(two_files):
    two_files()
    module = sys.modules["small_kernel"]
    assert (module.middle(21), module.times(21), module.middle(1.5)) == (42, 42, 3.0)


SHARED = """
from typing import NamedTuple

import numpy as np
from workbench.compiled import batch_loop, inner, shared

class Task(NamedTuple):
    values: np.ndarray
    factor: float

FACTOR = 2

@inner
def scaled(task, i):
    return FACTOR * task.factor * task.values[i]

@shared
def total(task, scale):
    found = 0.0
    for i in range(len(task.values)):
        found += scale * scaled(task, i)
    return found

@shared
def twice(task):
    return total(task, 2.0)

@batch_loop
def one(task, out):
    out[0] = total(task, 1.0)

@batch_loop
def two(task, out):
    out[1] = twice(task) + total(task, 1.0)
"""
RUN = """
import numpy as np
from sharing import Task, one, two

out = np.zeros(2)
for entry in (two, one):
    entry(Task(np.array([1.0, 2.0, 4.0]), 1.0), out)
print(out.tolist(), sum(sum(entry.stats.cache_misses.values()) for entry in (one, two)))
"""


@pytest.fixture
def sharing(tmp_path, monkeypatch):
    """Run two entries that share two functions in a new process; what it prints."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)

    def printed(change=str):
        (tmp_path / "sharing.py").write_text(change(SHARED))
        (tmp_path / "run.py").write_text(RUN)
        command = [sys.executable, str(tmp_path / "run.py")]
        done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    return printed


def test_what_entries_share_is_compiled_once_and_read_by_later_processes(sharing, tmp_path):
    """With the sum 7: 2 x 7 = 14, and twice that and once more, 42. Two entries are compiled."""
    assert sharing() == "[14.0, 42.0] 2"
    names = [path.name for path in files(tmp_path, "nbc")]
    assert len(names) == 4 and sum(".shared." in name for name in names) == 2
    assert sharing() == "[14.0, 42.0] 0"
    for path in files(tmp_path, "nbc"):
        if "total.shared" in path.name:
            path.unlink()
    assert sharing() == "[14.0, 42.0] 0"
    assert [path.name for path in files(tmp_path, "nbc")] == names


def test_a_change_below_what_is_shared_recompiles_all_that_reaches_it(sharing):
    assert sharing() == "[14.0, 42.0] 2"
    assert sharing(lambda text: text.replace("FACTOR = 2", "FACTOR = 20")) == "[140.0, 420.0] 2"
    assert sharing(lambda text: text.replace("@shared", "@inner")) == "[14.0, 42.0] 2"
    assert sharing() == "[14.0, 42.0] 2"


def test_where_no_folder_can_be_written_to_nothing_is_kept(kernel, tmp_path, monkeypatch):
    def no_folder(kernel, form):
        raise RuntimeError(f"cannot cache function {kernel.__name__!r}: no locator available")

    monkeypatch.setattr(compiled_linked, "_Cache", no_folder)
    assert kernel()(21) == 42 and not files(tmp_path, "nb?")


def test_a_full_disk_stops_nothing(kernel, tmp_path, monkeypatch):
    def full(self, path):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(compiled_linked._Files, "_open_for_write", full)
    assert compiled_anew(kernel) and not files(tmp_path, "nbc")


def test_every_kernel_is_compiled_by_the_checked_cache():
    plain = re.compile(r"from numba import .*\bnjit\b|numba\.njit|import numba\b")
    sources = tracked("workbench/**/*.py")
    found = [path.name for path in sources if plain.search(path.read_text())]
    assert sorted(found) == ["compiled.py", "compiled_linked.py"]


@pytest.fixture
def asked_anew():
    """`why_plain` as a new process asks it, before and after."""
    why_plain.cache_clear()
    yield
    why_plain.cache_clear()


@pytest.mark.parametrize("version", ["0.62.1", "0.99.0", "1.0.0rc1", "2.0"])
def test_a_version_of_numba_that_nobody_tested_compiles_by_itself(version, asked_anew, monkeypatch):
    monkeypatch.setattr(compiled.numba, "__version__", version)
    assert f"numba {version} is none of 0.{TESTED[0][1]} to 0.{TESTED[1][1]}" in why_plain()


def test_what_numba_has_no_more_is_no_error(asked_anew, monkeypatch):
    monkeypatch.setitem(sys.modules, "workbench.compiled_linked", None)
    assert "lacks what the quick compiler stands on" in why_plain()


def test_the_installed_numba_is_one_that_was_tested(asked_anew):
    assert why_plain() == ""


def told(code, folder, **environment):
    """What code prints in a process of its own, and its messages."""
    ran = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"NUMBA_CACHE_DIR": str(folder), **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return ran.stdout, ran.stderr


JOINED = """
import numpy as np
from workbench.geometry.components import component_labels
print(component_labels(np.array([0, 3, 4]), np.array([2, 4, 5]), 6))
"""


def test_numba_alone_gives_the_same_answers_and_keeps_what_it_compiled(tmp_path):
    linked, nothing = told(JOINED, tmp_path)
    plain, words = told(JOINED, tmp_path, WORKBENCH_COMPILER="plain")
    assert plain == linked == "[0 1 0 2 2 2]\n" and not nothing
    assert words.startswith("WORKBENCH_COMPILER=plain: kernels are compiled by numba alone; first")
    (folder,) = tmp_path.glob("plain-*")
    kept = sorted(folder.rglob("*.nb?"))
    assert kept and told(JOINED, tmp_path, WORKBENCH_COMPILER="plain")[0] == plain
    assert sorted(folder.rglob("*.nb?")) == kept


VERDICTS = """
import workbench as wb
for verdict in wb.run(wb.load_study("trainer_clearance")).verdicts:
    print(verdict.criterion.name, verdict.passed, round(verdict.worst.margin, 9))
"""


@pytest.mark.nightly
def test_a_whole_study_is_answered_alike_by_numba_alone(tmp_path):
    plain, _ = told(VERDICTS, tmp_path, WORKBENCH_COMPILER="plain")
    assert plain == told(VERDICTS, tmp_path)[0] != ""
