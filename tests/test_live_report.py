"""The report that a page of the live bench asks for: of the study, or of many people beside it."""

from __future__ import annotations

import json

import pytest

from tests.made_report import reported
from tests.made_seat import corners, obj_text
from workbench.cli import main

pytest.importorskip("starlette", reason="the extra `live` is not installed")
pytest.importorskip("httpx2", reason="Starlette's test client needs httpx2")
pytest.importorskip("uvicorn", reason="the extra `live` is not installed")

from tests.test_live import asked, client_of, entered, frames_until, page_of
from workbench.live.desk import Desk

CAB = """environment: cab
length: m
meshes:
  - {file: cab.obj, length: m, up: z, forward: x}
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "cab.obj").write_text(obj_text({"floor": corners((0, -2, -0.01), (4, 2, 0))}))
    (tmp_path / "environment.yaml").write_text(CAB)
    assert main(["new", str(tmp_path / "environment.yaml")]) == 0
    return tmp_path / "study.yaml"


def bench_of(study, **more):
    return client_of(Desk(str(study), **more), runner=reported)


def last_of(page, verb="report", **given):
    """What is told of a run, up to its end."""
    page.send_text(json.dumps({"n": 7, "do": verb, **given}))
    told = [{"words": "asked for"}]
    while "words" in told[-1]:
        told.append(frames_until(page, "report")[0])
    return told[1:]


def test_how_far_a_run_is_is_told_then_its_first_sentence_and_only_its_files_are_served(study):
    (study.parent / "out").mkdir()
    with bench_of(study) as client, page_of(entered(client)) as page:
        assert client.get("/report/report.html").status_code == 404
        *on_the_way, found = last_of(page)
        assert [one["words"] for one in on_the_way] == [
            "the report is asked for",
            "asking everybody: 1 of 3 people, 2 s left",
        ]
        assert (found["study"], found["headline"]) == ("study.yaml", "Two of three.")
        (study.parent / "out" / "mine.html").write_text("<script>")
        served = client.get("/report/report.html")
        assert served.text == "<p>Two of three"
        assert "connect-src" not in served.headers["content-security-policy"]
        assert served.headers["content-security-policy"].startswith("default-src 'none'")
        assert client.get("/report/tables/a.csv").text == "1\n"
        for name in (
            "mine.html",
            "../study.yaml",
            "%2e%2e/study.yaml",
            "tables",
            "",
            "/etc/passwd",
        ):
            assert client.get(f"/report/{name}").status_code == 404, name
        with page_of(client) as late:
            assert frames_until(late, "report")[0]["headline"] == "Two of three."


def test_many_people_are_asked_by_the_file_that_the_command_writes_and_none_is_written_over(study):
    people = study.with_stem("study_people")
    with bench_of(study) as client, page_of(entered(client)) as page:
        found = last_of(page, people=3)[-1]
        assert (
            found["study"] == people.name and "a first study of environment.yaml" in found["note"]
        )
        made = people.read_bytes()
        people.unlink()
        main(["new", str(study.with_name("environment.yaml")), "--people", "3"])
        assert people.read_bytes() == made
        people.write_text("# mine\n")
        fault = asked(page, "report", people=3)
        assert (fault["kind"], fault["ask"]) == ("fault", "people")
        assert last_of(page, people=3, how="anew")[-1]["study"] == "study_people_2.yaml"
        assert people.read_text() == "# mine\n"
        assert study.with_stem("study_people_2").read_bytes() == made
    with bench_of(study.with_stem("study_people_2")) as client, page_of(entered(client)) as page:
        assert "asks many people already" in asked(page, "report", people=3)["words"]


def test_a_run_is_ended_another_one_meanwhile_refused_and_a_fault_told_in_words(study):
    people = study.with_stem("study_people")
    with bench_of(study) as client, page_of(entered(client)) as page:
        people.write_text("# long\n")
        page.send_text(json.dumps({"n": 7, "do": "report", "people": 3, "how": "as it is"}))
        frames_until(page, "report")
        frames_until(page, "report")
        asked(page, "report")
        assert "end that, or wait" in frames_until(page, "fault")[0]["words"]
        assert last_of(page, "report_end")[-1]["ended"]
        people.write_text("# wrong\n")
        found = last_of(page, people=3, how="as it is")[-1]
        assert found["fault"] == f"{people}: it is wrong"


def test_who_may_not_write_or_has_not_saved_is_told_so(study):
    with bench_of(study, read_only=True) as client, page_of(entered(client)) as page:
        assert "read only" in asked(page, "report")["words"]
    with bench_of("trainer_clearance") as client, page_of(entered(client)) as page:
        assert "one of the catalogue" in asked(page, "report", people=3)["words"]
        asked(page, "joint", person="pilot", joint="LE", axis=0, degrees=20)
        assert "save the study first" in asked(page, "report")["words"]
