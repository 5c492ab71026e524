"""Outputs: no file of the user's is lost, an old result is there whole or a new one is, wherever a
run is killed."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.conftest import ROOT
from tests.killed import killed_before
from tests.one_arm_cab import write_cab
from workbench import InputError
from workbench.cli import main
from workbench.files import output_folder
from workbench.files.file_errors import note_input, noted_inputs
from workbench.files.output_file import check_file, staged, write_file
from workbench.files.output_folder import MANIFEST, check_folder, write_folder

OLD = {"result.json": "old", "old.csv": "1,2\n", "sub/deep.txt": b"deep"}
NEW = {"result.json": "new", "report.html": "<html>"}
MINE = {
    "notes.txt": "years of work",
    "photos/one.png": "one",
    "photos/two/three.png": "three",
    "sub/mine.txt": "mine",
}
linux = pytest.mark.skipif(
    sys.platform != "linux", reason="forks, and exchanges folders in one step"
)


def write(folder, files, **options):
    write_folder(folder, files, holds="result", **options)


def add(folder, files):
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def content(folder):
    """Bytes of all files of a folder by name; of a link, what it points to."""
    return {
        path.relative_to(folder).as_posix(): str(path.readlink()).encode()
        if path.is_symlink()
        else path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_symlink() or path.is_file()
    }


def own(folder):
    """The files that a folder's manifest lists, whose hashes are checked."""
    listed = json.loads((folder / MANIFEST).read_text())["files"]
    found = content(folder)
    assert {name: hashlib.sha256(found[name]).hexdigest() for name in listed} == listed
    return {name: found[name] for name in listed}


def as_bytes(files):
    return {name: text.encode() if isinstance(text, str) else text for name, text in files.items()}


@pytest.fixture
def folder(tmp_path):
    """A result in which its user keeps files too."""
    write(tmp_path / "out", OLD)
    add(tmp_path / "out", MINE)
    return tmp_path / "out"


def test_a_manifest_lists_the_files_with_their_hashes_and_is_the_same_each_time(tmp_path):
    for name in ("one", "two"):
        write(tmp_path / name, dict(reversed(NEW.items())) if name == "two" else NEW)
    manifest = json.loads((tmp_path / "one" / MANIFEST).read_text())
    assert manifest["format"] == "bubbleman-workbench manifest 1" and manifest["holds"] == "result"
    assert manifest["files"] == {
        name: hashlib.sha256(text.encode()).hexdigest() for name, text in sorted(NEW.items())
    }
    assert content(tmp_path / "one") == content(tmp_path / "two")


def test_only_listed_files_are_replaced_and_all_others_stay(folder):
    before = (folder / "photos/one.png").stat()
    (folder / "empty").mkdir()
    (folder / "link").symlink_to("/nowhere")
    write(folder, NEW)
    assert own(folder) == as_bytes(NEW)
    wanted = as_bytes(NEW | MINE) | {
        "link": b"/nowhere",
        MANIFEST: (folder / MANIFEST).read_bytes(),
    }
    assert content(folder) == wanted
    assert (folder / "empty").is_dir()
    after = (folder / "photos/one.png").stat()
    assert (after.st_ino, after.st_mtime_ns, after.st_nlink) == (
        before.st_ino,
        before.st_mtime_ns,
        1,
    )
    assert [path.name for path in folder.parent.iterdir()] == ["out"]


def test_an_edited_file_is_kept_under_another_name_and_told(folder):
    told = []
    for text in ("my words", "my later words"):
        (folder / "result.json").write_text(text)
        write(folder, NEW, tell=told.append)
    assert own(folder) == as_bytes(NEW)
    assert (folder / "result.kept.json").read_text() == "my words"
    assert (folder / "result.kept-2.json").read_text() == "my later words"
    assert told == [
        "result.json: was edited since it was written; it is kept as result.kept.json",
        "result.json: was edited since it was written; it is kept as result.kept-2.json",
    ]


def test_an_edited_file_that_the_new_result_has_no_more_stays(folder):
    (folder / "old.csv").write_text("edited")
    write(folder, NEW, tell=pytest.fail)
    assert (folder / "old.csv").read_text() == "edited"
    assert set(own(folder)) == set(NEW)


def test_files_and_folders_of_the_user_in_the_way_of_new_ones_are_kept_aside(folder):
    told = []
    add(folder, {"report.html/page.txt": "a folder of mine", "tables": "a file of mine"})
    write(folder, NEW | {"tables/a.csv": "1"}, tell=told.append)
    assert own(folder) == as_bytes(NEW | {"tables/a.csv": "1"})
    assert (folder / "report.kept.html/page.txt").read_text() == "a folder of mine"
    assert (folder / "tables.kept").read_text() == "a file of mine"
    assert len(told) == 2 and all("is not a file of the result" in line for line in told)


def test_a_file_that_appears_during_the_writing_is_not_lost(folder):
    def parts():
        yield "new"
        add(folder, {"late.txt": "late", "later/still.txt": "later"})
        (folder / "old.csv").write_text("edited late")

    write(folder, {"result.json": parts()})
    real = output_folder.exchange

    def late(first, second):
        add(
            folder,
            {"latest.txt": "latest", "photos/last.png": "last", "result.json": "edited last"},
        )
        return real(first, second)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(output_folder, "exchange", late)
        write(folder, NEW)
    found = content(folder)
    late_ones = {
        "late.txt": "late",
        "later/still.txt": "later",
        "latest.txt": "latest",
        "photos/last.png": "last",
    }
    assert as_bytes(
        MINE | late_ones | {"old.csv": "edited late", "result.kept.json": "edited last"} | NEW
    ).items() <= (found.items())


@pytest.mark.parametrize("missing", ["links", "exchange", "both"])
def test_without_hard_links_or_an_exchange_nothing_is_lost_either(folder, monkeypatch, missing):
    def refuse(*_, **__):
        raise OSError(errno.EPERM, "Operation not permitted")

    if missing != "exchange":
        monkeypatch.setattr(os, "link", refuse)
    if missing != "links":
        monkeypatch.setattr(output_folder, "exchange", lambda *_: False)
    (folder / "result.json").write_text("edited")
    told = []
    write(folder, NEW, tell=told.append)
    assert own(folder) == as_bytes(NEW)
    assert as_bytes(MINE | {"result.kept.json": "edited"}).items() <= content(folder).items()
    assert len(told) == 1
    assert [path.name for path in folder.parent.iterdir()] == ["out"]


@pytest.mark.parametrize(
    "name", ["result.json", "comparison.json", "people.csv", "notes.txt", MANIFEST]
)
def test_a_folder_without_a_manifest_of_ours_is_refused_whatever_it_holds(tmp_path, name):
    add(tmp_path / "out", {name: "{}", "thesis.txt": "years of work"})
    for attempt in (
        lambda: check_folder(tmp_path / "out", holds="result"),
        lambda: write(tmp_path / "out", NEW),
    ):
        with pytest.raises(InputError, match=r"is not a result of the workbench|is damaged"):
            attempt()
    assert content(tmp_path / "out") == {name: b"{}", "thesis.txt": b"years of work"}
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_folder_that_holds_another_kind_is_refused(folder):
    with pytest.raises(InputError, match="holds a result, not bodies of people"):
        write_folder(folder, NEW, holds="people")
    assert own(folder) == as_bytes(OLD)


def test_a_manifest_cannot_make_files_elsewhere_be_removed(tmp_path):
    victim = tmp_path / "victim.txt"
    victim.write_text("precious")
    listed = {
        name: hashlib.sha256(b"precious").hexdigest()
        for name in ("../victim.txt", str(victim), "link")
    }
    add(
        tmp_path / "out",
        {
            MANIFEST: json.dumps(
                {"format": "bubbleman-workbench manifest 1", "holds": "result", "files": listed}
            )
        },
    )
    (tmp_path / "out/link").symlink_to(victim)
    write(tmp_path / "out", NEW)
    assert victim.read_text() == "precious"
    assert (tmp_path / "out/link").is_symlink()


def test_a_result_is_replaced_through_a_link_and_from_within(tmp_path, monkeypatch):
    write(tmp_path / "out", OLD)
    (tmp_path / "latest").symlink_to("out")
    write(tmp_path / "latest", NEW)
    monkeypatch.chdir(tmp_path / "out")
    write(Path(), {"result.json": "3"})
    assert own(tmp_path / "out") == own(tmp_path / "latest") == {"result.json": b"3"}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["latest", "out"]


def test_a_link_planted_at_the_name_of_the_work_folder_is_not_followed(tmp_path):
    add(tmp_path / "mine", {"sub/notes.txt": "years of work", "one.txt": "1"})
    (tmp_path / ".out.workbench").symlink_to(tmp_path / "mine")
    write_anew = [(tmp_path / "out", OLD), (tmp_path / "out", NEW)]
    for folder, files in write_anew:
        with pytest.raises(InputError, match="beside it is a link"):
            write(folder, files)
    assert content(tmp_path / "mine") == as_bytes(
        {"sub/notes.txt": "years of work", "one.txt": "1"}
    )


@linux
@pytest.mark.parametrize("first", [True, False])
def test_killed_at_any_step_the_old_result_is_whole_or_the_new_one_and_nothing_is_lost(
    tmp_path, first
):
    write(tmp_path / "whole", NEW)
    wanted = content(tmp_path / "whole") | ({} if first else as_bytes(MINE))
    states = set()
    number = 1
    while True:
        out = tmp_path / f"{number}" / "out"
        if not first:
            write(out, OLD)
            add(out, MINE)
        killed = killed_before(number, out.parent, lambda out=out: write(out, NEW))
        state = own(out) if out.exists() else {}
        states.add(state.get("result.json"))
        assert state in ({} if first else as_bytes(OLD), as_bytes(NEW)), number
        assert first or as_bytes(MINE).items() <= content(out).items(), number
        write(out, NEW)
        assert content(out) == wanted, number
        assert [path.name for path in out.parent.iterdir()] == ["out"], number
        if not killed:
            break
        number += 1
    assert states == {None if first else b"old", b"new"}
    assert number > (5 if first else 20)


@linux
@pytest.mark.parametrize("seed", range(12))
def test_killed_again_and_again_also_while_it_cleans_up_nothing_is_lost(tmp_path, seed):
    random = np.random.default_rng(seed)
    out = tmp_path / "out"
    write(out, OLD)
    add(out, MINE)
    wanted = [as_bytes(files | {f"{k}.csv": "x"}) for files in (OLD, NEW) for k in range(5)] + [
        as_bytes(OLD)
    ]
    for k in range(5):
        files = (NEW, OLD)[k % 2] | {f"{k}.csv": "x"}
        killed_before(int(random.integers(1, 45)), tmp_path, lambda files=files: write(out, files))
        assert own(out) in wanted
        assert as_bytes(MINE).items() <= content(out).items()
    write(out, NEW)
    assert content(out).keys() == {*NEW, *MINE, MANIFEST}
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@linux
def test_killed_in_the_middle_of_a_file_the_old_result_stays(folder):
    def parts():
        yield "half of it"
        os.kill(os.getpid(), 9)

    assert killed_before(10**6, folder, lambda: write(folder, {"result.json": parts()}))
    assert own(folder) == as_bytes(OLD)
    assert check_folder(folder, holds="result") == folder
    assert [path.name for path in folder.parent.iterdir()] == ["out"]


@linux
def test_killed_without_an_exchange_the_next_check_puts_the_old_result_back(tmp_path, monkeypatch):
    monkeypatch.setattr(output_folder, "exchange", lambda *_: False)
    gone = 0
    number = 1
    killed = True
    while killed:
        out = tmp_path / f"{number}" / "out"
        write(out, OLD)
        add(out, MINE)
        killed = killed_before(number, out.parent, lambda out=out: write(out, NEW))
        gone += not out.exists()
        check_folder(out, holds="result")
        assert own(out) in (as_bytes(OLD), as_bytes(NEW)), number
        assert as_bytes(MINE).items() <= content(out).items(), number
        assert [path.name for path in out.parent.iterdir()] == ["out"], number
        number += 1
    assert gone == 1


@pytest.mark.parametrize(
    "error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()]
)
@pytest.mark.parametrize("place", ["_put", "_link_users", "exchange"])
def test_an_error_at_any_step_leaves_the_old_result(folder, monkeypatch, error, place):
    before = content(folder)
    monkeypatch.setattr(output_folder, place, lambda *_, **__: (_ for _ in ()).throw(error))
    with pytest.raises((InputError, KeyboardInterrupt)):
        write(folder, NEW)
    assert content(folder) == before
    assert [path.name for path in folder.parent.iterdir()] == ["out"]


def test_two_commands_that_write_one_folder_take_turns(folder):
    def once(number):
        check_folder(folder, holds="result")
        write(folder, NEW | {f"{number}.csv": str(number)})

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)  # so that they meet at every step
    try:
        with ThreadPoolExecutor(8) as pool:
            for written in [pool.submit(once, number % 8) for number in range(80)]:
                written.result()
    finally:
        sys.setswitchinterval(interval)
    assert own(folder).keys() in [{*NEW, f"{k}.csv"} for k in range(8)]
    assert as_bytes(MINE).items() <= content(folder).items()
    assert [path.name for path in folder.parent.iterdir()] == ["out"]


def test_a_file_is_replaced_in_one_step_and_a_killed_write_leaves_the_old_one(tmp_path):
    out = tmp_path / "body.yaml"
    write_file(out, "old")
    number = 1
    while killed_before(number, tmp_path, lambda: write_file(out, ["n", "ew"])):
        assert out.read_text() in ("old", "new")
        write_file(out, "old")
        assert [path.name for path in tmp_path.iterdir()] == ["body.yaml"]
        number += 1
    assert out.read_text() == "new" and number > 3


def test_a_file_that_another_command_writes_is_refused(tmp_path):
    with staged(tmp_path / "film.gif") as partial:
        partial.write_bytes(b"long work")
        with pytest.raises(InputError, match="another command is writing it now"):
            write_file(tmp_path / "film.gif", "x")
    assert (tmp_path / "film.gif").read_bytes() == b"long work"


def test_no_file_is_written_over_a_folder_a_link_a_device_or_an_input(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    add(tmp_path, {"target.txt": "mine", "input.txt": "read"})
    (tmp_path / "link").symlink_to("target.txt")
    (tmp_path / "hard").hardlink_to(tmp_path / "input.txt")
    os.mkfifo(tmp_path / "pipe")
    with noted_inputs():
        note_input(tmp_path / "input.txt")
        for name, why in [
            (".", "is a folder"),
            ("..", "is a folder"),
            ("/", "is a folder"),
            (str(tmp_path), "is a folder"),
            ("link", "is a link to target.txt"),
            ("pipe", "is no regular file"),
            ("/dev/null", "is no regular file"),
            ("input.txt", "is an input of this command"),
            ("hard", "is an input of this command"),
            ("input.txt/x", "Not a directory"),
            ("x" * 250, "File name too long"),
            ("/proc/x", "No such file"),
        ]:
            for attempt in (check_file, lambda path: write_file(path, "new")):
                with pytest.raises(InputError, match=rf"cannot be written \({why}"):
                    attempt(Path(name))
    assert (tmp_path / "target.txt").read_text() == "mine" and (
        tmp_path / "input.txt"
    ).read_text() == "read"
    assert len(list(tmp_path.iterdir())) == 5


@pytest.fixture
def unprivileged():
    """A folder under /tmp, and rights that are those of nobody."""
    if not hasattr(os, "geteuid"):
        pytest.skip("no users here")
    place = Path(tempfile.mkdtemp(prefix="workbench-test-"))
    place.chmod(0o755)
    if os.geteuid() == 0:
        os.seteuid(65534)
        yield place
        os.seteuid(0)
    else:
        place.chmod(0o555)
        yield place
        place.chmod(0o755)
    shutil.rmtree(place)


def test_a_read_only_folder_is_found_before_the_work(unprivileged):
    for out in (unprivileged / "out", unprivileged / "new/out"):
        with pytest.raises(InputError, match=r"cannot be written \(Permission denied\)"):
            check_file(out)
        with pytest.raises(InputError, match=r"cannot be written \(Permission denied\)"):
            check_folder(out, holds="result")


def commands(body, study, mesh):
    """Every command that writes, without its output."""
    return {
        "run": ["run", study, "--out"],
        "compare": ["compare", study, study, "--out"],
        "render": ["render", body, "--size", "16", "-o"],
        "body scale": ["body", "scale", body, "--stature", "1700 mm", "-o"],
        "body fit": ["body", "fit", mesh, "-o"],
        "people": ["people", "percentile", "--sex", "male", "--bodies"],
        "convert": ["motion", "convert", mesh, "-o"],
        "simulate": ["motion", "simulate", study, "-o"],
        "forces": ["motion", "simulate", study, "-o", "motion.csv", "--forces"],
    }


ENDINGS = {
    "render": ".png",
    "body scale": ".yaml",
    "body fit": ".yaml",
    "convert": ".csv",
    "simulate": ".csv",
    "forces": ".csv",
}


@pytest.mark.parametrize("command", commands("", "", ""))
def test_an_output_that_cannot_be_is_found_before_anything_is_read(
    tmp_path, monkeypatch, capsys, command
):
    monkeypatch.chdir(tmp_path)
    add(tmp_path, {"file": "in the way", "full/mine.txt": "mine"})
    words = commands("no_such_body", "no_such_study", "no_such_mesh.obj")[command]
    ending = ENDINGS.get(command, "")
    for out in (f"file/out{ending}", f"/proc/out{ending}", f"{'x' * 250}{ending}"):
        assert main([*words, out]) == 3
        assert "cannot be written" in capsys.readouterr().err
    if ending:
        (tmp_path / f"folder{ending}").mkdir()
        assert main([*words, f"folder{ending}"]) == 3
        assert "is a folder; name the file to write" in capsys.readouterr().err
    else:
        assert main([*words, "full"]) == 3
        assert "is not a result of the workbench" in capsys.readouterr().err
    assert (tmp_path / "full/mine.txt").read_text() == "mine"


def test_a_point_as_output_is_told_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["body", "scale", "bubbleman", "--stature", "1700 mm", "-o", "."]) == 3
    assert capsys.readouterr().err == ".: cannot be written (is a folder; name the file to write)\n"
    assert main(["body", "fit", "x.obj", "-o", "."]) == 3
    assert capsys.readouterr().err == ".: cannot be written (is a folder; name the file to write)\n"


@pytest.fixture
def cab(tmp_path):
    """The small study with its body, postures and environment, as files of its user."""
    return write_cab(tmp_path / "cab").parents[1]


OVER_INPUTS = {
    "a body by itself": [
        "body",
        "scale",
        "bubbleman.yaml",
        "--stature",
        "1700 mm",
        "-o",
        "bubbleman.yaml",
    ],
    "its postures by a body": [
        "body",
        "scale",
        "bubbleman.yaml",
        "--mass",
        "90 kg",
        "-o",
        "human_postures.yaml",
    ],
    "a mesh by its spheres": ["body", "fit", "ball.obj", "--length", "m", "-o", "ball.obj"],
    "the mesh of an environment by its picture": [
        "render",
        "glass",
        "-o",
        "environments/glass/box.glb",
    ],
    "a motion by itself": [
        "motion",
        "convert",
        "move.csv",
        "--body",
        "bodies/one_arm.yaml",
        "-o",
        "move.csv",
    ],
}


@pytest.mark.parametrize("what", OVER_INPUTS)
def test_no_command_writes_over_what_it_reads(cab, monkeypatch, capsys, what):
    monkeypatch.chdir(cab)
    write_inputs(cab)
    before = content(cab)
    code = main(OVER_INPUTS[what])
    assert "is an input of this command; name another file" in capsys.readouterr().err
    assert code == 3
    assert content(cab) == before


def write_inputs(cab):
    """A body with its postures, a mesh, an environment with a mesh of the kind that is written too,
    and a motion."""
    for name in ("bubbleman.yaml", "human_postures.yaml"):
        shutil.copy(ROOT / "bodies" / name, cab)
    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.1)
    ball.export(cab / "ball.obj")
    (cab / "environments/glass").mkdir()
    trimesh.creation.box().export(cab / "environments/glass/box.glb")
    text = "environment: glass\nlength: mm\nmeshes: [{file: box.glb}]\n"
    (cab / "environments/glass/environment.yaml").write_text(text)
    (cab / "move.csv").write_text("time [s], ELBOW.flexion [deg]\n0, 0\n1, 90\n")


def test_people_are_not_written_over_the_body_that_they_are_made_from(tmp_path, capsys):
    out = tmp_path / "men"
    words = ["people", "percentile", "--sex", "male", "--p", "50", "--bodies", str(out)]
    assert main(words) == 0
    before = content(out)
    assert main([*words, "--body", str(out / "male_50.yaml")]) == 3
    assert "male_50.yaml in it is an input of this command" in capsys.readouterr().err
    assert content(out) == before


def test_run_keeps_the_files_of_its_user_and_tells_of_edited_ones(cab, capsys):
    words = ["run", str(cab / "studies/cab_study.yaml"), "--out", str(cab / "out")]
    assert main(words) == 0
    result = own(cab / "out")
    add(cab / "out", MINE | {"verdicts.csv": "my verdict"})
    capsys.readouterr()
    assert main(words) == 0
    kept = "warning: verdicts.csv: was edited since it was written; it is kept as verdicts.kept.csv"
    assert kept in capsys.readouterr().err.splitlines()
    assert own(cab / "out") == result
    assert (
        as_bytes(MINE | {"verdicts.kept.csv": "my verdict"}).items() <= content(cab / "out").items()
    )


def test_run_writes_into_the_current_folder(cab, monkeypatch, capsys):
    (cab / "empty").mkdir()
    monkeypatch.chdir(cab / "empty")
    assert main(["run", str(cab / "studies/cab_study.yaml"), "--out", "."]) == 0
    assert "report.html" in own(cab / "empty")
    assert capsys.readouterr().out.endswith("report.html\n")


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The small study, and the content of its result as a run leaves it that nobody interrupts."""
    study = write_cab(tmp_path_factory.mktemp("finished"))
    assert main(["run", str(study), "--out", str(study.parent / "out")]) == 0
    return study, content(study.parent / "out")


def killed_run(study, out, steps):
    """`workbench run` over an earlier result with files of its user, in a process that is killed on
    the way.

    Then one result is whole, the user has all files, and the next run completes it. Returns whether
    it was killed.
    """
    study, whole = study
    write(out, OLD)
    add(out, MINE)
    code = "import sys; from pathlib import Path; from tests.killed import *; from workbench.cli import main\n"
    code += f"kill_before({steps}); sys.exit(main(['run', {str(study)!r}, '--out', {str(out)!r}]))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, cwd=ROOT, check=False, timeout=300
    )
    found = content(out)
    assert found == whole | as_bytes(MINE) or own(out) == as_bytes(OLD)
    assert as_bytes(MINE).items() <= found.items()
    assert main(["run", str(study), "--out", str(out)]) == 0
    assert content(out) == whole | as_bytes(MINE)
    assert [path.name for path in out.parent.iterdir()] == ["out"]
    assert done.returncode in (-9, 0), done.stderr
    return done.returncode == -9


@linux
def test_a_run_killed_at_the_exchange_leaves_one_result_whole_and_the_next_completes_it(
    finished, tmp_path
):
    assert killed_run(finished, tmp_path / "out", f"1, Path({str(tmp_path)!r}), [EXCHANGE]")


@linux
@pytest.mark.nightly
def test_a_run_killed_at_any_step_leaves_one_result_whole_and_the_next_completes_it(
    finished, tmp_path
):
    number = 1
    while killed_run(
        finished, tmp_path / f"{number}/out", f"{number}, Path({str(tmp_path / str(number))!r})"
    ):
        number += 1
    assert number > 50


@linux
@pytest.mark.nightly
def test_a_run_killed_at_any_time_leaves_one_result_whole_and_the_next_completes_it(cab):
    """At 60 random times, from the first import to the end."""
    study = cab / "studies/cab_study.yaml"
    out = cab / "out"
    random = np.random.default_rng(13)
    command = [sys.executable, "-m", "workbench", "run", str(study), "--out", str(out)]
    began = time.monotonic()
    subprocess.run(command, check=True, capture_output=True)
    whole = own(out)
    seconds = time.monotonic() - began
    add(out, MINE)
    killed = 0
    for moment in random.uniform(0, 1.1 * seconds, 60):
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(moment)
        process.kill()
        killed += process.wait() == -9
        assert own(out) == whole
        assert as_bytes(MINE).items() <= content(out).items()
    subprocess.run(command, check=True, capture_output=True)
    assert own(out) == whole and killed > 20
    assert not [path.name for path in cab.iterdir() if path.name.startswith(".")]
