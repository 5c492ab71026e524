"""The command line: exit codes, data on stdout and talk on stderr, never a traceback, folders whole
or not at all."""

from __future__ import annotations

import csv
import io
import json
import os
import subprocess
import sys

import jsonschema
import pytest

from tests.one_arm_cab import IN_PIECES, STUDY, changed, lines_of, write_cab
from workbench.cli import main
from workbench.cli.progress import emit_verdict, tell
from workbench.files import output_folder
from workbench.files.yaml_text import read_yaml

COMMANDS = {
    "run": "STUDY",
    "check": "FILES",
    "inspect": "SOURCE",
    "render": "SOURCE",
    "schema": "KIND",
    "doctor": "--json",
    "body list": "--json",
    "body show": "BODY",
}
STRICT = changed(STUDY, "at_least: 100", "at_least: 300")
LIGHT = ("numba", "scipy", "trimesh", "pyvista", "PIL", "numpy", "jinja2", "pydantic")


@pytest.fixture(scope="module")
def cab(tmp_path_factory):
    return write_cab(tmp_path_factory.mktemp("cab"))


@pytest.fixture(scope="module")
def finished(cab):
    """A folder with the result of the small study, of which every criterion holds."""
    folder = cab.parents[1] / "finished"
    assert main(["run", str(cab), "--out", str(folder)]) == 0
    return folder


def answer(capsys, *arguments):
    """(exit code, stdout, stderr) of a command line."""
    capsys.readouterr()
    code = main([str(argument) for argument in arguments])
    told = capsys.readouterr()
    assert "Traceback" not in told.out + told.err
    return code, told.out, told.err


def started(*arguments, **settings):
    """The same in a process of its own."""
    return subprocess.run(
        [sys.executable, "-W", "error", "-m", "workbench", *map(str, arguments)],
        capture_output=True,
        check=False,
        timeout=600,
        **settings,
    )


def content(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(capsys, command):
    code, out, err = answer(capsys, *command.split(), "--help")
    assert (code, err) == (0, "")
    assert out.startswith(f"Usage: workbench {command}")
    assert COMMANDS[command] in out


def test_help_lists_all_commands_and_exit_codes_and_loads_nothing_heavy():
    code = f"import sys; from workbench.cli import main; c = main(['--help']); print({LIGHT} & sys.modules.keys(), c)"
    code = code.replace(str(LIGHT), str(set(LIGHT)))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("set() 0\n")
    assert all(f"│ {command.split()[0]} " in done.stdout for command in COMMANDS)
    told = " ".join(done.stdout.split())
    assert (
        "Exit codes: 0 fine, 1 a criterion failed, 2 usage, 3 bad input, 4 an optional part is missing"
        in told
    )
    assert "70 an internal error, 130 stopped by Ctrl-C." in told


def test_version_and_no_arguments(capsys):
    assert answer(capsys, "--version") == (0, "0.1.0\n", "")
    assert answer(capsys)[0] == 0


def test_run_writes_the_folder_and_tells_the_verdicts(capsys, cab, tmp_path):
    code, out, err = answer(capsys, "run", cab, "--out", tmp_path / "new" / "out")
    assert (code, err) == (0, f"warning: {IN_PIECES}\n")
    assert [line.split()[0] for line in out.splitlines()[:5]] == ["passed"] * 5
    headline, page = out.splitlines()[-2:]
    assert headline.startswith("2 people in 2 cases: all 5 criteria hold, nearest to its limit “")
    assert " The tightest gap is " in headline and page == f"{tmp_path}/new/out/report.html"
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["out"]


def test_run_goes_to_out_and_the_name_of_the_study_where_not_told(
    capsys, cab, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert answer(capsys, "run", cab)[1].endswith("out/cab_study/report.html\n")
    assert (tmp_path / "out/cab_study/result.json").is_file()


def test_a_failed_criterion_is_exit_code_1_and_json_is_all_that_stdout_gets(capsys, tmp_path):
    path = write_cab(tmp_path, study=STRICT)
    code, out, err = answer(capsys, "run", path, "--out", tmp_path / "out", "--json")
    assert (code, err) == (1, f"warning: {IN_PIECES}\n")
    assert json.loads(out) == json.loads((tmp_path / "out/result.json").read_text())
    assert not json.loads(out)["passed"]


def test_the_result_is_valid_by_the_published_schema(capsys, finished):
    code, out, _ = answer(capsys, "schema", "result")
    assert code == 0
    jsonschema.Draft202012Validator.check_schema(json.loads(out))
    jsonschema.validate(json.loads((finished / "result.json").read_text()), json.loads(out))


@pytest.mark.parametrize(
    ("kind", "file"),
    [
        ("body", "bodies/one_arm.yaml"),
        ("postures", "bodies/arms.yaml"),
        ("study", "studies/cab_study.yaml"),
        ("environment", "environments/cab/environment.yaml"),
    ],
)
def test_the_schema_of_a_kind_accepts_a_good_file_and_no_misspelt_key(capsys, cab, kind, file):
    code, out, err = answer(capsys, "schema", kind)
    assert (code, err) == (0, "")
    jsonschema.Draft202012Validator.check_schema(json.loads(out))
    value = read_yaml(cab.parents[1] / file).value
    jsonschema.validate(value, json.loads(out), cls=jsonschema.Draft202012Validator)
    with pytest.raises(jsonschema.ValidationError, match="misspelt"):
        jsonschema.validate(
            value | {"misspelt": 1}, json.loads(out), cls=jsonschema.Draft202012Validator
        )


def test_check_names_the_good_files_and_all_faults_of_the_bad(capsys, cab, tmp_path):
    one = cab.with_name("one.yaml")
    one.write_text(changed(STUDY, "title", "titel"))
    (tmp_path / "two.yaml").write_text("body: x\n")
    root = cab.parents[1]
    good = [cab, root / "bodies/one_arm.yaml", root / "bodies/arms.yaml", root / "environments/cab"]
    code, out, err = answer(capsys, "check", *good, one, tmp_path / "two.yaml")
    assert code == 3
    assert out == "".join(f"{path}: ok\n" for path in good)
    assert lines_of(tuple(err.splitlines())) == [2, 1, 1]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["fly"], 2, 'Unknown command "fly"'),
        (["run"], 2, "requires an argument"),
        (["run", "a", "b", "c"], 2, "workbench --help lists the commands."),
        (["run", "x.yaml", "--ot", "y"], 2, "Unknown option: --ot. Did you mean --out?"),
        (["check"], 2, "name one file or more"),
        (["schema", "bodies"], 2, "no schema 'bodies'; did you mean 'body'? valid: body, postures"),
        (["render", "bubbleman"], 2, "--out requires an argument"),
        (
            ["render", "bubbleman", "--out", "x.jpg"],
            2,
            "x.jpg: the ending says what to make; valid: .png",
        ),
        (
            ["render", "bubbleman", "--out", "x.png", "--size", "big"],
            2,
            "pixels such as 800 or 1280x720",
        ),
        (["render", "bubbleman", "--out", "x.png", "--size", "9x900"], 2, "16 to 8192 pixels"),
        (
            ["render", "bubbleman", "--out", "x.png", "--view", "up"],
            2,
            "no view 'up'; valid: front",
        ),
        (
            ["render", "bubbleman", "--out", "x.svg", "--display", "circels"],
            2,
            "no display 'circels'; did you mean",
        ),
        (
            ["inspect", "trainer", "--units", "mm"],
            2,
            "--units, --up and --forward are for mesh files",
        ),
        (["run", "no_such_study"], 3, "no studies entry named 'no_such_study'; valid: "),
        (["run", "no/such.yaml"], 3, "no/such.yaml: no such file (looked from "),
        (["run", "x" * 5000], 3, "no studies entry named"),
        (["run", "\0"], 3, "no studies entry named"),
        (["run", ""], 3, "no studies entry named"),
        (["check", "none.yaml"], 3, "none.yaml: no such file"),
        (["check", "x" * 5000], 3, "File name too long"),
        (["check", "/"], 3, "no such file"),
        (["inspect", "none.obj"], 3, "none.obj"),
        (["inspect", "no_such_cab"], 3, "no environments entry named 'no_such_cab'"),
        (["render", "nobody", "--out", "x.png"], 3, "nothing is called 'nobody'"),
        (
            ["render", "bubbleman", "--out", "x.png", "--pose", "std"],
            3,
            "no posture 'std'; did you mean 'seated'?",
        ),
        (["body", "show", "nobody"], 3, "no bodies entry named 'nobody'"),
        (["body", "shwo"], 2, "shwo"),
    ],
)
def test_wrong_calls_are_2_bad_input_is_3_and_stdout_stays_empty(
    capsys, tmp_path, monkeypatch, arguments, code, words
):
    monkeypatch.chdir(tmp_path)
    found, out, err = answer(capsys, *arguments)
    assert (found, out) == (code, "")
    assert words in err
    assert list(tmp_path.iterdir()) == []


def test_a_missing_optional_part_is_4_and_says_what_to_install(capsys, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "cascadio", None)
    (tmp_path / "part.step").write_text(
        "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"
    )
    code, out, err = answer(capsys, "inspect", tmp_path / "part.step", "--units", "mm")
    assert (code, out) == (4, "")
    assert "pip install" in err


def test_inspect_tells_parts_as_text_and_as_json(capsys, cab):
    code, out, err = answer(capsys, "inspect", cab.parents[1] / "environments/cab")
    assert (code, err) == (0, "")
    assert "5 parts, 60 faces, 30 polygons" in out
    code, out, _ = answer(
        capsys, "inspect", cab.parents[1] / "environments/cab/cab.obj", "--units", "m", "--json"
    )
    assert code == 0
    assert [part["name"] for part in json.loads(out)["parts"]] == [
        "floor",
        "wall",
        "seat",
        "rest",
        "secret",
    ]


def test_body_list_and_show_speak_text_and_json(capsys, cab, monkeypatch):
    monkeypatch.chdir(cab.parents[1])
    code, out, err = answer(capsys, "body", "list")
    assert (code, err) == (0, "")
    assert {line.split(":")[0] for line in out.splitlines()} >= {"bubbleman", "one_arm"}
    assert {row["name"] for row in json.loads(answer(capsys, "body", "list", "--json")[1])} >= {
        "bubbleman",
        "one_arm",
    }
    assert "thumb tip" in answer(capsys, "body", "show", "one_arm")[1]
    assert json.loads(answer(capsys, "body", "show", "one_arm", "--json")[1])["postures"] == {
        "hanging": "the arm straight down",
        "bent": "elbow bent to a right angle",
    }


@pytest.mark.parametrize(
    ("source", "more"),
    [
        ("bodies/one_arm.yaml", ["--pose", "bent"]),
        ("environments/cab", []),
        ("studies/cab_study.yaml", ["--case", "forward"]),
    ],
)
def test_render_draws_a_body_an_environment_and_a_case(capsys, cab, tmp_path, source, more):
    for display, ending, head in (("disks", "png", b"\x89PNG"), ("circles", "svg", b"<svg")):
        out = tmp_path / f"picture.{ending}"
        wanted = [
            "render",
            cab.parents[1] / source,
            "--out",
            out,
            "--display",
            display,
            "--size",
            "64",
            *more,
        ]
        code, said, cut_off = answer(capsys, *wanted)
        assert (code, said) == (0, f"{out}\n")
        assert all("beyond the picture" in line for line in cut_off.splitlines())
        assert out.read_bytes().startswith(head)
    assert sorted(path.name for path in tmp_path.glob("picture.*")) == [
        "picture.png",
        "picture.svg",
    ]


def test_render_makes_no_folder_in_silence(capsys, cab, tmp_path):
    out = tmp_path / "new/picture.png"
    code, said, told = answer(
        capsys, "render", cab.parents[1] / "bodies/one_arm.yaml", "--out", out
    )
    assert (code, said) == (3, "")
    assert told == f"{out}: there is no folder {out.parent}; make it first\n"
    assert not out.parent.exists()


def test_run_says_nothing_where_it_is_asked_to_be_quiet(capsys, cab, tmp_path):
    study = cab.parents[1] / "studies/cab_study.yaml"
    code, said, _ = answer(capsys, "run", study, "-o", tmp_path / "out", "-q")
    assert code in (0, 1) and said == ""
    assert (tmp_path / "out/report.html").is_file()


class _Terminal(io.StringIO):
    """Text that says it goes to a terminal."""

    def isatty(self):
        return True


@pytest.mark.parametrize(("plain", "lead"), [("", "\x1b[1;31mFAILED\x1b[0m"), ("1", "FAILED")])
def test_verdicts_are_coloured_and_broken_between_words_on_a_terminal(monkeypatch, plain, lead):
    shown = _Terminal()
    monkeypatch.setattr(sys, "stdout", shown)
    monkeypatch.setenv("NO_COLOR", plain)
    monkeypatch.setenv("COLUMNS", "40")
    emit_verdict("FAILED  knees: " + "left_lower_leg is 12.3 mm into panel. " * 3)
    lines = shown.getvalue().splitlines()
    assert lines[0].startswith(f"{lead}  knees:") and len(lines) > 2
    assert all(line.startswith("        ") and len(line) <= 40 for line in lines[1:])
    assert "".join(lines).count("left_lower_leg") == 3  # no word is broken


def test_warnings_are_broken_between_words_on_a_terminal(monkeypatch):
    shown = _Terminal()
    monkeypatch.setattr(sys, "stderr", shown)
    monkeypatch.setenv("COLUMNS", "40")
    tell("warning: " + "left_lower_leg is 12.3 mm into panel. " * 3)
    lines = shown.getvalue().splitlines()
    assert len(lines) > 2 and max(map(len, lines)) <= 40
    assert "".join(lines).count("left_lower_leg") == 3


def test_render_leaves_nothing_where_it_cannot_write(capsys, cab, tmp_path):
    (tmp_path / "picture.png").mkdir()
    code, _, err = answer(
        capsys,
        "render",
        cab.parents[1] / "environments/cab",
        "--out",
        tmp_path / "picture.png",
        "--size",
        "16",
    )
    assert code == 3
    assert "cannot be written" in err
    assert [path.name for path in tmp_path.iterdir()] == ["picture.png"]


def test_doctor_names_every_part(capsys, monkeypatch):
    monkeypatch.setattr("workbench.report.diagnostics._off_screen", lambda: "not tried")
    assert "numba: " in answer(capsys, "doctor")[1]
    assert {"python", "numpy", "pyvista", "cascadio"} <= json.loads(
        answer(capsys, "doctor", "--json")[1]
    ).keys()


def warned(done):
    """What a process warned of; on a slow machine it says how far it is, too."""
    lines = done.stderr.decode().splitlines()
    return [line for line in lines if line.startswith("warning: ")]


def test_a_second_run_in_another_process_gives_the_same_bytes(cab, finished, tmp_path):
    environment = os.environ | {"PYTHONHASHSEED": "7", "LC_ALL": "C"}
    done = started("run", cab, "--out", tmp_path / "again", env=environment)
    assert (done.returncode, warned(done)) == (0, [f"warning: {IN_PIECES}"])
    assert content(tmp_path / "again") == content(finished)


def test_what_is_not_a_result_is_never_replaced(capsys, cab, tmp_path):
    (tmp_path / "precious").mkdir()
    (tmp_path / "precious/thesis.txt").write_text("years of work")
    (tmp_path / "file").write_text("a file")
    for name in ("precious", "file"):
        code, _, err = answer(capsys, "run", cab, "--out", tmp_path / name)
        assert code == 3
        assert "is there already and is not a result of the workbench; choose another --out" in err
    assert (tmp_path / "precious/thesis.txt").read_text() == "years of work"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "precious"]


def test_a_failed_write_of_the_run_command_is_3_and_an_interrupt_130(
    capsys, cab, tmp_path, monkeypatch
):
    full = OSError(28, "No space left on device")
    for error, code, words in (
        (full, 3, "out: cannot be written (No space"),
        (KeyboardInterrupt(), 130, "stopped"),
    ):
        monkeypatch.setattr(
            output_folder, "_put", lambda *_, error=error: (_ for _ in ()).throw(error)
        )
        found, _, err = answer(capsys, "run", cab, "--out", tmp_path / "out")
        assert found == code
        assert words in err
        assert list(tmp_path.iterdir()) == []


def test_an_out_that_cannot_be_is_3(capsys, cab, tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "loop").symlink_to("loop")
    for out in ("file/out", "x" * 300, "loop"):
        code, _, err = answer(capsys, "run", cab, "--out", tmp_path / out)
        assert code == 3
        assert "cannot be written" in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "loop"]


def test_a_reader_who_leaves_early_is_no_error(cab):
    for arguments in (["body", "show", "bubbleman", "--json"], ["check", str(cab)]):
        command = [sys.executable, "-m", "workbench", *arguments]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            process.stdout.close()
            assert process.stderr.read() == b""
        assert process.returncode == 0


def test_a_terminal_without_the_letters_gets_numbers_and_json_stays_json(tmp_path):
    path = write_cab(tmp_path, study=changed(STUDY, "name: down", "name: größer"))
    done = started(
        "run",
        path,
        "--out",
        tmp_path / "out",
        "--json",
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
    )
    assert (done.returncode, warned(done)) == (0, [f"warning: {IN_PIECES}"])
    assert json.loads(done.stdout)["cases"][0] == "größer"


def test_no_colour_codes_are_written_to_a_pipe(cab):
    done = started("--help", env=os.environ | {"NO_COLOR": "1", "FORCE_COLOR": ""})
    assert done.returncode == 0
    assert b"\x1b" not in done.stdout + done.stderr


def test_an_output_on_the_terminal_is_the_same_table_as_in_the_files(
    capsys, finished, cab, tmp_path
):
    _, out, _ = answer(capsys, "run", cab, "--out", tmp_path / "out")
    rows = csv.DictReader(io.StringIO((finished / "verdicts.csv").read_text()))
    shown = {"yes": "passed", "no": "FAILED"}
    assert out.splitlines()[:5] == [
        f"{shown[r['passed']]}  {r['criterion']}: {r['sentence']}" for r in rows
    ]


def test_names_from_files_never_steer_the_terminal(tmp_path, capfd):
    mesh = tmp_path / "a\x1b[2J.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\no seat\x1b]0;title\x07\nf 1 2 3\n")
    for arguments in (
        ["inspect", str(mesh)],
        ["inspect", str(mesh), "--json"],
        ["check", str(mesh)],
    ):
        main(arguments)
        out, err = capfd.readouterr()
        assert "\x1b" not in out + err and "\x07" not in out + err
        assert "u001b" in out + err
