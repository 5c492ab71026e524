"""Damaged files: no reader answers one with a traceback, takes much memory, or works on one for
long."""

from __future__ import annotations

import json
import subprocess
import sys
import warnings

import pytest

from tests.conftest import ROOT, SHARED, needs_real_input, real_input
from tests.fuzzing import LONGEST, READERS, mutation
from workbench import InputError, WorkbenchError, read_ansur
from workbench.files.meshes.reading import FORMATS, read_mesh
from workbench.files.motions.markers import read_c3d, read_trc
from workbench.files.motions.reading import MOTIONS, read_motion


def searched(reader, first, count):
    """What a child process with bounded memory found among some mutations."""
    command = [sys.executable, "-m", "tests.fuzzing", reader, str(first), str(count)]
    done = subprocess.run(
        command,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=count * LONGEST + 120,
        check=False,
    )
    assert done.returncode == 0, (
        f"{reader}: the process ended with {done.returncode}\n{done.stderr[-2000:]}"
    )
    return json.loads(done.stdout.splitlines()[-1])


SLOW = [
    pytest.param(name, marks=pytest.mark.nightly) for name, how in READERS.items() if how.sample < 2
]


@pytest.mark.parametrize(
    "reader", [*(name for name, how in READERS.items() if how.sample >= 2), *SLOW]
)
def test_the_files_that_are_damaged_are_whole_before(reader, tmp_path):
    how = READERS[reader]
    if reader == "step":
        pytest.skip("a STEP file that holds bodies is too large to damage by the thousand")
    how.prepare(tmp_path)
    path = tmp_path / f"{how.place}{how.ending}"
    path.parent.mkdir(parents=True, exist_ok=True)
    for seed in how.seeds:
        path.write_bytes(seed)
        how.read(path)


def test_a_sample_of_damaged_files_is_read_or_refused(tmp_path):
    for reader, how in READERS.items():
        if how.sample < 2:
            continue
        folder = tmp_path / reader
        folder.mkdir()
        how.prepare(folder)
        path = folder / f"{how.place}{how.ending}"
        path.parent.mkdir(parents=True, exist_ok=True)
        for number in range(how.sample):
            path.write_bytes(mutation(reader, number))
            try:
                how.read(path)
            except WorkbenchError as error:
                assert all("\n" not in line for line in getattr(error, "problems", ())), (
                    reader,
                    number,
                )


@pytest.mark.nightly
@pytest.mark.parametrize("reader", READERS)
def test_damaged_files_are_read_or_refused_within_bounds_of_memory_and_time(reader):
    found = searched(reader, 0, READERS[reader].nightly)
    assert not found["findings"], found["findings"][:3]
    assert found["read"] + found["refused"] == READERS[reader].nightly


def test_the_nightly_search_reads_a_hundred_thousand_files():
    assert sum(how.nightly for how in READERS.values()) >= 100_000


def real_files(*endings):
    """The real inputs of some formats; one that is skipped where they are absent."""
    found = [
        pytest.param(path, id=path.name)
        for path in sorted(SHARED.rglob("*"))
        if path.suffix.lower() in endings and "ansur" not in str(path)
    ]
    return found or [pytest.param(SHARED, id="none", marks=needs_real_input(SHARED))]


@pytest.mark.nightly
@pytest.mark.parametrize("path", real_files(*FORMATS))
def test_real_meshes_lose_no_face(path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        raw = read_mesh(path)
    assert sum(len(part.faces) for part in raw.parts) > 0
    assert not [note for note in raw.notes if "left out" in note and "lines" not in note]


@pytest.mark.nightly
@pytest.mark.parametrize("path", real_files(*MOTIONS))
def test_real_motions_are_read(path, one_arm):
    read = {".trc": read_trc, ".c3d": read_c3d}.get(
        path.suffix.lower(), lambda p: list(read_motion(p, one_arm))
    )
    assert read(path)


@pytest.mark.nightly
def test_a_population_read_from_a_broken_copy_is_refused_and_not_shortened(tmp_path):
    whole = real_input(SHARED / "anthropometry" / "ansur2" / "ANSUR_II_FEMALE_Public.csv")
    data = whole.read_bytes()
    (tmp_path / "cut.csv").write_bytes(data[: len(data) // 2 - 7])
    with pytest.raises(InputError, match="cells are needed"):
        read_ansur(tmp_path / "cut.csv")
