"""Compiled code that is kept is believed only where it is whole and made from these kernels."""

from __future__ import annotations

import importlib.util
import pickle
import re
import sys

import pytest
from numba.core.config import reload_config

from tests.conftest import tracked
from tests.test_index_cache import DAMAGE
from workbench.kernels import compiled
from workbench.kernels.compiled import source_stamp

KERNEL = """
from workbench.kernels.compiled import njit

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
    path.write_text(KERNEL)

    def fresh():
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
    assert len(files(tmp_path, "nbi")) == len(files(tmp_path, "nbc")) == 1


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_file_is_compiled_and_kept_again(kernel, tmp_path, ending, damage):
    compiled_anew(kernel)
    path = files(tmp_path, ending)[0]
    whole = path.read_bytes()
    path.write_bytes(DAMAGE[damage](whole))
    assert compiled_anew(kernel) and not compiled_anew(kernel)
    assert len(path.read_bytes()) == len(whole)


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_a_file_that_is_gone_or_is_a_folder_stops_nothing(kernel, tmp_path, ending):
    compiled_anew(kernel)
    path = files(tmp_path, ending)[0]
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


def test_two_processes_that_keep_code_at_once_never_run_each_others(kernel, monkeypatch):
    """One keeps code for other arguments between the reading and the writing of the index by the
    other, so both choose the same file; what is lost is compiled again."""
    write_index = compiled._Files._save_index
    other = kernel()

    def interrupted(files, overloads):
        monkeypatch.setattr(compiled._Files, "_save_index", write_index)
        assert other(21.5) == 43.0
        write_index(files, overloads)

    monkeypatch.setattr(compiled._Files, "_save_index", interrupted)
    assert kernel()(21) == 42
    assert kernel()(21.5) == 43.0 and kernel()(21) == 42
    assert not compiled_anew(kernel)


def test_a_file_of_the_compiler_itself_is_not_read(kernel, tmp_path):
    compiled_anew(kernel)
    for ending in ("nbi", "nbc"):
        files(tmp_path, ending)[0].write_bytes(pickle.dumps("0.0") + pickle.dumps(("stamp", {})))
    assert compiled_anew(kernel)


def test_a_change_of_any_kernel_forgets_what_was_made_of_all(kernel, tmp_path, monkeypatch):
    folder = tmp_path / "kernels"
    (folder / "limbs").mkdir(parents=True)
    monkeypatch.setattr(compiled, "KERNELS", folder)
    changes = [
        lambda: (folder / "lanes.py").write_text("one = 1\n"),
        lambda: (folder / "limbs" / "steps.py").write_text("one = 1\n"),
        lambda: (folder / "lanes.py").write_text("one = 11\n"),
        lambda: (folder / "lanes.py").rename(folder / "other.py"),
        lambda: (folder / "other.py").unlink(),
    ]
    for change in changes:
        change()
        source_stamp.cache_clear()
        assert compiled_anew(kernel) and not compiled_anew(kernel)
    (folder / "limbs" / "steps.py").touch()
    source_stamp.cache_clear()
    assert not compiled_anew(kernel)
    monkeypatch.setattr(compiled, "_versions", lambda: ["another compiler"])
    source_stamp.cache_clear()
    assert compiled_anew(kernel)
    source_stamp.cache_clear()


def test_where_no_folder_can_be_written_to_nothing_is_kept(kernel, tmp_path, monkeypatch):
    def no_folder(function):
        raise RuntimeError(f"cannot cache function {function.__name__!r}: no locator available")

    monkeypatch.setattr(compiled, "_Cache", no_folder)
    assert kernel()(21) == 42 and not (tmp_path / "__pycache__").exists()


def test_a_full_disk_stops_nothing(kernel, tmp_path, monkeypatch):
    def full(self, path):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(compiled._Files, "_open_for_write", full)
    assert compiled_anew(kernel) and not files(tmp_path, "nbi")


def test_every_kernel_is_compiled_by_the_checked_cache():
    plain = re.compile(r"from numba import .*\bnjit\b|numba\.njit|import numba\b")
    sources = tracked("workbench/**/*.py")
    found = [path.name for path in sources if plain.search(path.read_text())]
    assert found == ["compiled.py"]
