"""Two who save one file at once, names that are planted, and files that are no files any more."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from tests.conftest import ROOT
from workbench.errors import InputError
from workbench.files.output_file import replaced, saving, write_file
from workbench.files.study.saving import ChangedFileError, read_text, save_text

STUDY = (ROOT / "studies" / "trainer_clearance.yaml").read_text()


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(STUDY)
    return path


def saved_at_once(path, texts):
    """Save texts in as many threads, all from the same text as opened: what each came to."""
    opened = read_text(path)
    gate = threading.Barrier(len(texts))
    came = {}

    def save(text):
        gate.wait()
        try:
            save_text(opened, text, lambda study: None)
            came[text] = "saved"
        except ChangedFileError:
            came[text] = "changed"

    threads = [threading.Thread(target=save, args=(text,)) for text in texts]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return came


def test_of_those_who_save_at_once_one_is_confirmed_and_that_is_what_the_file_says(path):
    for number in range(4):
        texts = [f"{STUDY}# {who} {number}\n" for who in ("one", "another", "a third")]
        came = saved_at_once(path, texts)
        assert sorted(came.values()) == ["changed", "changed", "saved"]
        assert came[path.read_text()] == "saved"
    assert [one.name for one in path.parent.iterdir()] == ["a.yaml"]


HOLDS = """
import sys, time
from pathlib import Path
from workbench.files.output_file import saving
with saving(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


def test_a_file_is_waited_for_while_another_process_saves_it_and_free_once_that_was_killed(path):
    opened = read_text(path)
    command = [sys.executable, "-c", HOLDS, str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=ROOT) as holder:
        assert holder.stdout.readline() == b"held\n"
        threading.Timer(0.5, holder.kill).start()
        begin = time.monotonic()
        save_text(opened, STUDY + "# more\n", lambda study: None)
        assert 0.4 < time.monotonic() - begin < 9.0
    assert path.read_text().endswith("# more\n")


def test_a_child_that_was_started_meanwhile_keeps_no_lock(path):
    opened = read_text(path)
    with saving(path):
        files = [one for one in Path("/proc/self/fd").iterdir() if one.resolve().suffix == ".lock"]
        kept = [os.dup(int(one.name)) for one in files]  # what a forked child has of it
    assert kept
    begin = time.monotonic()
    save_text(opened, STUDY, lambda study: None)
    assert time.monotonic() - begin < 9.0
    for file in kept:
        os.close(file)


@pytest.mark.parametrize("kind", ["link", "hard link", "pipe"])
def test_what_is_planted_at_a_temporary_name_is_neither_followed_nor_written(path, kind):
    victim = path.with_name("victim")
    victim.write_text("mine")
    with saving(path):
        lock = next(one for one in path.parent.iterdir() if one.name.endswith(".lock"))
    for planted in (lock, path.with_name(".b.yaml.workbench-partial")):
        if kind == "link":
            planted.symlink_to(victim)
        elif kind == "hard link":
            planted.hardlink_to(victim)
        else:
            os.mkfifo(planted)
    with pytest.raises(InputError, match="beside it is a link, or no file of its own; remove it"):
        save_text(read_text(path), STUDY + "# more\n", lambda study: None)
    with pytest.raises(InputError, match="beside it is a link, or no file of its own; remove it"):
        write_file(path.with_name("b.yaml"), "b: 1\n")
    assert victim.read_text() == "mine" and path.read_text() == STUDY


def test_a_study_that_was_replaced_by_a_pipe_is_neither_waited_for_nor_replaced(path):
    opened = read_text(path)
    path.unlink()
    os.mkfifo(path)
    assert opened.changed_on_disk()
    with pytest.raises(InputError, match="is a pipe"):
        read_text(path)
    with pytest.raises(InputError, match="is no regular file"):
        save_text(opened, STUDY, lambda study: None, over=True)


def test_what_cannot_be_read_leaves_the_file_and_nothing_beside_it(path):
    def refused(partial):
        raise InputError("no")

    with pytest.raises(InputError, match="no"), saving(path):
        replaced(path, b"other", refused)
    assert path.read_text() == STUDY
    assert [one.name for one in path.parent.iterdir()] == ["a.yaml"]


@pytest.mark.parametrize("stem", ["a" * 250, "ä" * 125, "-", "a b", "%s"])
def test_a_name_as_long_as_the_system_lets_it_be_is_saved_and_a_longer_one_refused(path, stem):
    opened = read_text(path)
    to = path.with_name(f"{stem}.yaml")
    assert save_text(opened, STUDY, lambda study: None, to=to).path == to
    longer = path.with_name(f"{stem}{'b' * 250}.yaml")
    with pytest.raises(InputError, match="cannot be written"):
        save_text(opened, STUDY, lambda study: None, to=longer)
