"""The README is true: its code runs, its commands exist, its picture is there, it is short."""

from __future__ import annotations

import re
import shlex

import pytest
import yaml

from tests.conftest import ROOT
from workbench.cli import app

TEXT = (ROOT / "README.md").read_text()
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", TEXT, re.S)


def test_the_readme_has_code_and_is_under_120_lines():
    assert [kind for kind, _ in BLOCKS].count("python") >= 1
    assert [kind for kind, _ in BLOCKS].count("sh") >= 3
    assert TEXT.count("\n") <= 120


def test_the_python_block_runs_and_prints_contacts(capsys):
    for code in (code for kind, code in BLOCKS if kind == "python"):
        exec(compile(code, "README.md", "exec"), {})
    assert " mm " in capsys.readouterr().out


@pytest.mark.parametrize(
    "line",
    [
        line
        for kind, code in BLOCKS
        if kind == "sh"
        for line in code.splitlines()
        if line.startswith("workbench ")
    ],
)
def test_every_command_line_parses(line):
    command, bound, _ = app.parse_args(
        shlex.split(line, comments=True)[1:], exit_on_error=False, print_error=False
    )
    assert command.__name__ in {
        "run",
        "check",
        "new",
        "inspect",
        "render",
        "body_scale",
        "body_measure",
        "boundary",
    }
    assert bound.arguments


def test_links_lead_to_files():
    for target in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert (ROOT / target).exists(), target


def test_the_first_lines_run_the_first_study():
    head = "\n".join(TEXT.splitlines()[:20])
    assert "workbench run studies/trainer_clearance.yaml" in head
    assert "docs/images/trainer.png" in head


def test_the_quoted_sentence_is_what_the_study_says():
    import workbench as wb
    from workbench.report.sentences import verdict_sentence

    result = wb.run(wb.load_study("trainer_clearance"))
    said = [f"passed  {v.criterion.name}: {verdict_sentence(v)}" for v in result.verdicts]
    quoted = re.search(r"```text\n(.*?)\n```", TEXT, re.S)[1]
    assert quoted in said


def test_the_formats_document_shows_postures_that_load():
    document = (ROOT / "docs" / "file-formats.md").read_text()
    from workbench.files.postures import PosturesFile
    from workbench.files.schema import validate
    from workbench.files.yaml_text import parse_yaml

    blocks = re.findall(r"```yaml\n(.*?)```", document, re.S)
    assert len(blocks) == 4
    validate(parse_yaml(blocks[1], "postures"), PosturesFile)


def test_the_page_on_study_files_shows_a_study_that_checks(tmp_path, capsys):
    from workbench.cli import main

    (block,) = re.findall(r"```yaml\n(.*?)```", (ROOT / "docs" / "studies.md").read_text(), re.S)
    path = tmp_path / "study.yaml"
    path.write_text(block)
    assert main(["check", str(path)]) == 0, capsys.readouterr().err


@pytest.mark.parametrize(
    ("page", "lead"),
    [
        ("motion-files.md", "study: sled"),
        ("driving.md", "driver:"),
        ("crash-simulation.md", "cases:"),
    ],
)
def test_other_pages_show_parts_of_studies_in_form(page, lead):
    from workbench.files.schema import validate
    from workbench.files.study.schema import StudyFile
    from workbench.files.yaml_text import parse_yaml

    blocks = re.findall(r"```yaml\n(.*?)```", (ROOT / "docs" / page).read_text(), re.S)
    (block,) = (block for block in blocks if block.startswith(lead))
    value = yaml.safe_load((ROOT / "studies" / "trainer_crash.yaml").read_text())
    found = yaml.safe_load(block)
    if page == "driving.md":
        found = {"cases": [{"name": "driving", "people": {"pilot": found}}]}
    text = yaml.safe_dump(value | found)
    assert validate(parse_yaml(text, page), StudyFile).cases


def test_the_page_on_study_files_names_every_key_of_the_format():
    from workbench.files.study.schema import CHECK_KEYS, StudyFile

    page = (ROOT / "docs" / "studies.md").read_text()
    for check, (needed, possible) in CHECK_KEYS.items():
        row = next(line for line in page.splitlines() if line.startswith(f"| `{check}` |"))
        assert all(key in row for key in (*needed, *possible)), row
    for key in StudyFile.model_fields:
        assert key in page
