"""The accommodation study on a toy cockpit: counts checked by other means, runs cut off, files, bad
luck."""

from __future__ import annotations

import csv
import errno
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import chain
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import workbench as wb
from tests.conftest import BOX, BOX_FACES, ROOT
from tests.crowds import crowd_of
from tests.test_index_cache import DAMAGE
from tests.toy_cockpit import STUDY, write_toy
from workbench import limb, load_study, reach
from workbench.cli import main
from workbench.contact import index_cache
from workbench.contact.clearance_pairs import ClearancePair, clearance_of_pairs
from workbench.files.kinds import json_schemas
from workbench.files.results.result import load_result
from workbench.model.accommodation import Change
from workbench.model.surroundings import move_parts
from workbench.report.folder import write_report
from workbench.report.population.rows import population_lines
from workbench.study import executors
from workbench.study.accommodation import population_bodies
from workbench.study.accommodation.accommodation import accommodation
from workbench.study.accommodation.checkpoints import forget_chunks, joined_chunks, result_chunks
from workbench.study.accommodation.gains import changed_question
from workbench.study.accommodation.population_bodies import PopulationBodies, fit_population

PEOPLE = 8


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    """The study's path, what it gives of its people, and their bodies in their seats."""
    path = write_toy(tmp_path_factory.mktemp("toy"), people=PEOPLE)
    study = crowd_of(path)
    return path, wb.run(study.study).population, (study, study.bodies)


def few_asked(study):
    """What is asked, without the first two requirements."""
    question = study.question
    members = np.zeros((len(question.asked) - 2, 0), dtype=bool)
    return replace(question, asked=question.asked[2:], members=members)


def reaching(study, bodies, at):
    """Who reaches a point with the right hand in zone 1, one by one with the plain solver."""
    found = []
    for body in bodies[:]:
        poses = study.seated(body, [0]).poses
        chain = limb(body, "right hand", grip="push", zone=1)
        found.append(
            bool(reach(body, poses, at, limb=chain, environment=study.environment).reached[0, 0])
        )
    return np.array(found)


def test_a_knob_put_where_exactly_so_many_reach_it_is_reached_by_so_many(toy, tmp_path):
    _, _, (study, bodies) = toy
    low = 0.7
    high = 1.0
    for _ in range(12):
        middle = (low + high) / 2
        count = int(reaching(study, bodies, [middle, -0.18, 0.85]).sum())
        if count == 3:
            break
        low, high = (middle, high) if count > 3 else (low, middle)
    assert count == 3
    path = write_toy(tmp_path, knob=1000 * middle, people=PEOPLE)
    result = wb.run(load_study(path)).population
    column = [r.name for r in result.requirements].index("reach knob by the right hand")
    assert int(result.met[:, column].sum()) == 3
    assert result.single[column] == pytest.approx(3 / PEOPLE)
    assert set(np.flatnonzero(result.met[:, column])) == set(
        np.flatnonzero(reaching(study, bodies, [middle, -0.18, 0.85]))
    )


def test_the_spare_of_a_reach_is_how_much_farther_it_would_still_be_reached(toy):
    _, result, (study, bodies) = toy
    column = [r.name for r in result.requirements].index("reach knob by the right hand")
    row = int(np.argmin(result.margin[:, column]))
    spare = result.margin[row, column]
    body = bodies[row]
    assert 0 < spare < 0.19
    poses = study.seated(body, [0]).poses
    placed = wb.place(body, poses)
    joint = body.joint("RS")
    world = placed.world_from_segment[0, joint + 1]
    shoulder = world[:, :3] @ body.joint_in_child[0, joint] + world[:, 3]
    way = np.array([0.7, -0.18, 0.85]) - shoulder
    way /= np.linalg.norm(way)
    chain = limb(body, "right hand", grip="push", zone=1)
    tried = [np.array([0.7, -0.18, 0.85]) + (spare + by) * way for by in (-0.002, 0.004)]
    assert reach(body, poses, tried, limb=chain).reached[0].tolist() == [True, False]


def test_margins_of_view_and_head_room_are_heights_that_can_be_measured(toy):
    _, result, (study, bodies) = toy
    names = [r.name for r in result.requirements]
    body = bodies[3]
    placed = wb.place(body, study.seated(body, [0]).poses)
    eyes = [
        placed.centres[0, body.sphere_names.index(f"{side} eye"), 2] for side in ("left", "right")
    ]
    assert result.margin[3, names.index("view")] == pytest.approx(
        0.06 - abs(np.mean(eyes) - 1.05), abs=1e-9
    )
    head = body.spheres(body.segment("H"))
    top = np.max(placed.centres[0, head, 2] + body.radius[0, head])
    assert result.margin[3, names.index("head room")] == pytest.approx(1.6 - top - 0.15, abs=1e-6)


def test_joint_shares_follow_from_the_margins(toy):
    _, result, _ = toy
    assert result.served.tolist() == np.all(result.margin >= -1e-6, axis=1).tolist()
    assert result.shares[0].share == pytest.approx(result.served.mean())
    out = ~result.served
    assert all(bool(name) == bool(o) for name, o in zip(result.limiting, out, strict=True))
    assert len(result.shown) == len(result.hardest) == min(5, int(out.sum()))


def test_many_bodies_are_placed_as_one_after_the_other(toy):
    _, _, (study, fitted) = toy
    bodies = fitted[:3]
    poses = study.seated(bodies, [0, 1, 2]).poses
    found = wb.place(bodies, poses)
    for b, body in enumerate(bodies):
        one = wb.Poses(
            poses.rotations[b : b + 1], poses.reference, poses.world_from_reference[b : b + 1]
        )
        alone = wb.place(body, one)
        assert np.array_equal(found.centres[b], alone.centres[0])
        assert np.array_equal(found.world_from_segment[b], alone.world_from_segment[0])


def test_clearances_of_many_are_those_of_each_in_the_environment_with_the_seat_moved(toy):
    _, _, (study, fitted) = toy
    bodies = fitted[:3]
    sitters = study.situations(bodies, [0, 1, 2])[0]
    shift = np.array([[0.01, 0, 0], [0, 0, 0.02], [-0.03, 0, 0.01]])
    moves = study.environment.seat("pilot").moves
    head = ClearancePair(
        bodies.sphere_segment == bodies.segment("H"),
        np.array([True, True, False, True]),
        False,
    )
    placed = wb.place(bodies, sitters.taken.poses)
    found = clearance_of_pairs(
        placed, study.environment, pairs=[head], moving_parts=moves, displacement=shift
    )
    for b, body in enumerate(bodies):
        one = sitters.taken.poses
        pose = wb.Poses(
            one.rotations[b : b + 1], one.reference, one.world_from_reference[b : b + 1]
        )
        room = move_parts(study.environment, moves, shift[b])
        near = wb.clearance(wb.place(body, pose), room)[0, body.segment("H")]
        assert found.distance[b, 0] == pytest.approx(
            near[3], abs=1e-12
        )  # pan and back may be touched: left out


def test_the_bodies_show_the_measures_of_their_people(toy):
    _, _, (study, bodies) = toy
    body = bodies[2]
    for name, found in wb.measure(
        body, ["thumb_tip_reach", "eye_height_sitting", "popliteal_height"]
    ).items():
        assert found == pytest.approx(study.people.column(name)[2], abs=3e-4)
    assert body.mass[0].sum() == pytest.approx(study.people.column("mass")[2])


def test_bodies_are_the_same_bytes_however_many_processes_fit_them(toy, monkeypatch):
    study = toy[2][0]
    monkeypatch.setenv("WORKBENCH_CACHE", "off")
    monkeypatch.setattr(population_bodies, "CHUNK_SIZE", 2)
    monkeypatch.setattr(population_bodies, "MAX_CHUNKS_TOGETHER", 1)
    found = []
    for cores in (1, 2):
        monkeypatch.setattr(executors, "available_cores", lambda cores=cores: cores)
        found.append(fit_population(study.body, study.people))
    for name, values in found[0].fields.items():
        assert values.tobytes() == found[1].fields[name].tobytes(), name


def test_kept_bodies_are_read_back_as_they_were(toy, tmp_path, monkeypatch):
    study = toy[2][0]
    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path))
    some = study.people.rows(np.arange(3))
    lines = []
    first = fit_population(study.body, some, progress=lambda *done: lines.append(done))
    again = fit_population(study.body, some, progress=lambda *done: pytest.fail(done))
    assert lines[0] == (0, 3) and lines[-1] == (3.0, 3) and lines == sorted(lines)
    assert all(np.array_equal(first.fields[n], again.fields[n]) for n in first.fields)
    assert first.notes == again.notes


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_file_of_bodies_is_fitted_anew(toy, tmp_path, monkeypatch, damage):
    study = toy[2][0]
    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path))
    some = study.people.rows(np.arange(1))
    first = fit_population(study.body, some)
    (path,) = (tmp_path / "people").iterdir()
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    lines = []
    again = fit_population(study.body, some, progress=lambda *done: lines.append(done))
    assert bool(lines) == (damage != "longer")  # bytes after the end of an archive are not read
    assert all(np.array_equal(first.fields[n], again.fields[n]) for n in first.fields)


def test_bodies_are_fitted_where_nothing_can_be_kept(toy, tmp_path, monkeypatch):
    study = toy[2][0]
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path / "file"))
    assert len(fit_population(study.body, study.people.rows(np.arange(2)))) == 2


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_chunk_is_worked_on_anew(toy, tmp_path, monkeypatch, damage):
    study, bodies = toy[2]
    monkeypatch.setattr(population_bodies, "CHUNK_SIZE", 4)
    monkeypatch.setattr(population_bodies, "MAX_CHUNKS_TOGETHER", 1)
    question = few_asked(study)
    lines = []
    first = result_chunks(question, bodies, keep=tmp_path, tell=lambda *done: lines.append(done))
    path = min(tmp_path.iterdir())
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    again = result_chunks(question, bodies, keep=tmp_path, tell=lambda *done: lines.append(done))
    assert [line for line in lines if not line[0]] == [(0, 8), (0, 0 if damage == "longer" else 4)]
    assert all(a.margin.tobytes() == b.margin.tobytes() for a, b in zip(first, again, strict=True))


def test_a_folder_that_cannot_be_written_gives_one_clear_message(toy, tmp_path):
    study, bodies = toy[2]
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(wb.InputError, match=r"file/keep: cannot be written \(Not a directory\)$"):
        keep = tmp_path / "file" / "keep"
        result_chunks(few_asked(study), bodies, keep=keep, tell=lambda done, total: None)


def test_the_result_has_its_published_shape_and_everybody_is_in_the_table(toy, tmp_path):
    path, found, _ = toy
    result = wb.run(load_study(path))
    rows = write_report(result, tmp_path / "out")
    data = json.loads((tmp_path / "out" / "result.json").read_text())
    jsonschema.validate(data, json_schemas()["result"])
    assert load_result(tmp_path / "out") == rows
    assert np.array_equal(result.population.margin, found.margin)
    assert rows.population.role == "pilot" and rows.postures == [] and rows.motions == []
    assert len(rows.population.people.label) == PEOPLE
    table = list(csv.DictReader((tmp_path / "out" / "people.csv").read_text().splitlines()))
    assert len(table) == PEOPLE
    assert float(table[0]["view [mm]"]) == pytest.approx(1000 * found.margin[0, 2], abs=1e-3)
    assert "%" in (tmp_path / "out" / "report.html").read_text()


def test_the_parquet_file_holds_the_same_table(toy, tmp_path):
    duckdb = pytest.importorskip("duckdb")
    path, result, _ = toy
    write_report(wb.run(load_study(path)), tmp_path / "out")
    found = duckdb.sql(
        f"select avg(\"view [mm]\"), count(*) from '{tmp_path}/out/people.parquet'"
    ).fetchall()[0]
    assert found == (pytest.approx(1000 * result.margin[:, 2].mean(), abs=1e-2), PEOPLE)


def test_a_command_that_wrote_parquet_ends_without_a_word_about_what_is_left():
    pytest.importorskip("duckdb")
    code = "import sys; sys.argv = ['workbench', '-V']; "
    code += "from workbench.files.parquet import parquet_bytes; parquet_bytes('a\\n1\\n'); "
    code += "from workbench.__main__ import main; raise SystemExit(main())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def command(path, out, *, chunk=2):
    code = f"import workbench.study.accommodation.population_bodies as p; p.CHUNK_SIZE = {chunk}; p.MAX_CHUNKS_TOGETHER = 1; from workbench.cli import main; "
    code += f"raise SystemExit(main(['run', {str(path)!r}, '--out', {str(out)!r}]))"
    return [sys.executable, "-c", code]


linux = pytest.mark.skipif(
    sys.platform != "linux", reason="audit hooks announce other paths elsewhere"
)


def killed(path, out, number, *, chunk=2):
    """Run a study in a process that ends itself before its step `number` in the folder of its
    chunks; returns whether it did."""
    run = command(path, out, chunk=chunk)
    kept = str(out.with_name(f".{out.name}.chunks"))
    run[2] = (
        f"import pathlib, tests.killed as k; k.kill_before({number}, pathlib.Path({kept!r})); {run[2]}"
    )
    return subprocess.run(run, capture_output=True, cwd=ROOT).returncode == -signal.SIGKILL


@linux
def test_a_run_that_is_killed_goes_on_and_gives_the_same_bytes(tmp_path, monkeypatch):
    path = write_toy(tmp_path / "toy", people=4)
    assert killed(path, tmp_path / "killed", 10, chunk=1)
    assert 2 <= len(list((tmp_path / ".killed.chunks").glob("*.chunk"))) < 4
    assert not (tmp_path / "killed").exists()
    monkeypatch.setattr(population_bodies, "CHUNK_SIZE", 1)
    monkeypatch.setattr(population_bodies, "MAX_CHUNKS_TOGETHER", 1)
    for name in ("killed", "whole"):
        assert main(["run", str(path), "--out", str(tmp_path / name)]) == 0
    assert not (tmp_path / ".killed.chunks").exists()
    assert content(tmp_path / "killed") == content(tmp_path / "whole")


def content(folder):
    return {file.name: file.read_bytes() for file in folder.iterdir()}


@linux
@pytest.mark.nightly
def test_a_run_killed_at_any_step_of_its_chunks_goes_on_and_gives_the_same_bytes(toy, tmp_path):
    """Before each file of a chunk is opened or renamed, and before each is removed when the work is
    done."""
    subprocess.run(command(toy[0], tmp_path / "whole"), check=True, capture_output=True)
    number = 1
    while killed(toy[0], tmp_path / f"{number}", number):
        subprocess.run(command(toy[0], tmp_path / f"{number}"), check=True, capture_output=True)
        assert content(tmp_path / f"{number}") == content(tmp_path / "whole"), number
        assert not (tmp_path / f".{number}.chunks").exists(), number
        number += 1
    assert number > 12


def test_what_was_half_written_when_a_run_was_killed_goes_with_its_chunks(tmp_path):
    for name in ("00000-a.chunk", "new-half"):
        (tmp_path / "keep").mkdir(exist_ok=True)
        (tmp_path / "keep" / name).write_text("x")
    forget_chunks(tmp_path / "keep")
    assert not list(tmp_path.iterdir())


def test_half_written_files_of_the_cache_go_after_a_day(tmp_path):
    for name, age in (("new-old", 2 * 86400), ("new-now", 0), ("other", 2 * 86400)):
        (tmp_path / name).write_text("x")
        os.utime(tmp_path / name, (time.time() - age,) * 2)
    index_cache.forget_partial(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"new-now", "other"}


def test_on_a_full_disk_the_run_stops_and_earlier_chunks_stay(toy, tmp_path, monkeypatch):
    monkeypatch.setattr(population_bodies, "CHUNK_SIZE", 2)
    monkeypatch.setattr(population_bodies, "MAX_CHUNKS_TOGETHER", 1)
    real = index_cache.tempfile.NamedTemporaryFile
    written = []

    def full(*args, **options):
        if len(written) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written.append(1)
        return real(*args, **options)

    monkeypatch.setattr(index_cache.tempfile, "NamedTemporaryFile", full)
    with pytest.raises(
        wb.InputError, match=r"\(No space left on device\)\n4 of 8 people are done and kept"
    ):
        accommodation(load_study(toy[0]), keep=tmp_path / "keep")
    assert len(list((tmp_path / "keep").iterdir())) == 2


@pytest.mark.parametrize(
    ("count", "cores", "size"),
    [
        (1, 2, 1),
        (16, 2, 16),
        (64, 2, 32),
        (200, 1, 100),
        (200, 8, 25),
        (200, 32, 16),
        (600, 2, 128),
        (6068, 64, 95),
    ],
)
def test_chunks_hold_everybody_once_and_keep_all_cores_at_work(monkeypatch, count, cores, size):
    monkeypatch.setattr(population_bodies, "available_cores", lambda: cores)
    bodies = PopulationBodies(None, np.zeros(count, dtype=np.int64), {}, ("",) * count)
    numbers = [list(range(count))[rows] for rows in bodies.chunks]
    assert list(chain.from_iterable(numbers)) == list(range(count))
    assert len(numbers[0]) == min(size, count)


def test_what_is_found_of_people_does_not_depend_on_who_is_worked_on_with_them(
    tmp_path, monkeypatch
):
    path = write_toy(tmp_path, knob=830, people=12)
    place = tmp_path / "environments" / "toy" / "environment.yaml"
    text = place.read_text()
    for old, new in (
        ("{forward: [0, 0], up: [0, 0]}", "{forward: [-100, 100], up: [-30, 30]}"),
        ("-180, 850]", "-180, 1000]"),
        ("[450, -200, 800]", "[-250, -550, 380]"),
    ):
        assert old in text
        text = text.replace(old, new)
    place.write_text(text)
    study = crowd_of(path)
    lower = Change("lower", travel_up=(-0.05, 0.02))
    found = []
    for size in (12, 1):
        monkeypatch.setattr(population_bodies, "CHUNK_SIZE", size)
        monkeypatch.setattr(population_bodies, "LEAST_CHUNK", size)
        monkeypatch.setattr(population_bodies, "MAX_CHUNKS_TOGETHER", 1)
        before = all_of(study.question, study.bodies)
        after = all_of(changed_question(study.question, before, lower), study.bodies)
        found.append((before, after))
    assert len(found[0][0].judged) > 100
    for one, other in zip(*found, strict=True):
        for name in ("margin", "seat", "window", "sets", "setting", "judged", "judged_person"):
            values = getattr(one, name)
            same = np.array_equal(values, getattr(other, name), equal_nan=values.dtype.kind == "f")
            assert same, name


def all_of(question, bodies):
    return joined_chunks(result_chunks(question, bodies, keep=None, tell=lambda done, total: None))


def test_the_command_says_what_leaves_people_out(toy, tmp_path, capsys):
    assert main(["run", str(toy[0]), "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "everybody" in said and "view" in said and "report.html" in said


def test_real_rows_with_weights_are_people_too(toy, tmp_path):
    _, result, (study, _) = toy
    names = [name for name in study.people.names if name != "mass"]
    lines = [",".join(["SubjectId", "Gender", "count", *names])]
    for row in range(4):
        sizes = [f"{100 * study.people.column(name)[row]:.3f}" for name in names]
        lines.append(
            ",".join([f"p{row}", ("Male", "Female")[study.people.sex[row]], str(row + 1), *sizes])
        )
    path = write_toy(
        tmp_path, swap={"{people: 10, seed: 3}": "{files: [four.csv], unit: cm, weights: count}"}
    )
    (path.parent / "four.csv").write_text("\n".join(lines) + "\n")
    found = wb.run(load_study(path)).population
    assert found.people.labels == ("p0", "p1", "p2", "p3")
    served = found.served
    weight = np.arange(1, 5)
    assert found.shares[0].share == pytest.approx(weight[served].sum() / 10)
    assert found.margin[:, 2] == pytest.approx(result.margin[:4, 2], abs=2e-3)


def of_figures(folder):
    """Changes that let a toy's people come from the figures of ANSUR II alone: among the eight of
    seed 3 two are too short for a far knob and too low to see."""
    folder.mkdir(exist_ok=True)
    text = (ROOT / "bodies" / "populations" / "ansur2.yaml").read_text()
    (folder / "figures.yaml").write_text(text.replace("people: ansur2.csv\n", ""))
    return {"population: {": "population: {source: ../figures.yaml, "}


def test_a_change_of_the_design_is_confirmed_by_a_run_with_it(toy, tmp_path):
    change = "changes:\n  - {name: moving knob 60 mm aft, control: knob, move: [-60, 0, 0]}\n"
    study = Path(toy[0]).read_text() + change
    path = write_toy(
        tmp_path,
        knob=850,
        study=study.replace(f"people: {PEOPLE}", "people: PEOPLE"),
        people=PEOPLE,
        swap=of_figures(tmp_path),
    )
    result = wb.run(load_study(path)).population
    nearer = tmp_path / "nearer"
    path = write_toy(nearer, knob=790, people=PEOPLE, swap=of_figures(nearer))
    nearer = wb.run(load_study(path)).population
    gain = result.gains[0]
    assert gain.requirement == "reach knob by the right hand" and gain.move == pytest.approx(0.06)
    assert gain.before == result.single[0] and gain.after == nearer.single[0] > gain.before
    assert gain.joint_after == pytest.approx(nearer.served.mean())
    column = [r.name for r in result.requirements].index(gain.requirement)
    short = result.margin[:, column] < -1e-6
    grown = nearer.margin[short, column] - result.margin[short, column]
    row = result.tried[0].person.row
    was, then = result.tried[0].margins
    assert was == result.margin[row, column] < 0.0 <= then and not result.served[row]
    still = nearer.margin[short, column] < -1e-6  # what is to spare is counted along another way
    assert gain.margin_rate == pytest.approx(np.mean(grown[still]) / 0.06, abs=0.1)


def test_what_is_proposed_lets_more_people_meet_everything(tmp_path):
    result = wb.run(load_study(write_toy(tmp_path, knob=890, people=PEOPLE))).population
    assert result.gains and all(gain.joint_after > gain.joint_before for gain in result.gains)
    knob = next(gain for gain in result.gains if gain.words.startswith("moving knob"))
    assert knob.words.endswith("aft") and knob.after > knob.before
    assert 0.5 < knob.margin_rate <= 1.0


def test_where_everybody_left_out_lacks_two_things_two_moves_are_proposed_together(tmp_path):
    """At 850 mm the two who are short of the knob, by 87 mm at most, are too low to see as well, by
    14 mm at most: no single move lets them in."""
    path = write_toy(tmp_path, knob=850, people=PEOPLE, swap=of_figures(tmp_path))
    result = wb.run(load_study(path)).population
    missed = ~result.met
    assert missed[:, 0].any() and np.all(missed.sum(axis=1) != 1)
    assert [(gain.words, gain.joint_before, gain.joint_after) for gain in result.gains] == [
        ("moving knob 90 mm aft and letting the seat go 20 mm higher", 0.75, 1.0),
        ("letting the seat go 90 mm farther forward and 20 mm higher", 0.75, 1.0),
    ]


@pytest.mark.parametrize(
    "change",
    [
        "controls: [kno*], move: [-90, 0, 0], seat: pilot, higher: 20",
        "moved: [{control: knob, by: [-9 cm, 0, 0]}], seat: pilot, higher: 20",
    ],
)
def test_a_control_and_the_seat_change_together(tmp_path, change):
    """Neither alone lets the two in who are short of the knob and too low to see."""
    study = STUDY + f"changes: [{{name: both, {change}}}]\n"
    swap = of_figures(tmp_path)
    result = wb.run(
        load_study(write_toy(tmp_path, knob=850, people=PEOPLE, study=study, swap=swap))
    )
    (gain,) = result.population.gains
    assert (gain.words, gain.joint_before, gain.joint_after) == ("both", 0.75, 1.0)
    assert gain.move == pytest.approx(0.09)


def test_a_lower_seat_is_proposed_to_those_whose_heads_are_too_near_to_the_roof(tmp_path):
    """Of eight people one fits; five more lack 45.2 mm of head room at most, and nothing else."""
    swap = of_figures(tmp_path) | {"at_least: 150": "at_least: 450"}
    result = wb.run(load_study(write_toy(tmp_path, people=PEOPLE, swap=swap))).population
    assert result.margin[:, 3].min() == pytest.approx(-0.0452, abs=1e-4)
    lower = next(gain for gain in result.gains if gain.words == "letting the seat go 46 mm lower")
    assert (lower.requirement, lower.joint_before, lower.joint_after) == ("head room", 0.125, 0.75)


@pytest.mark.parametrize(
    ("top", "lower", "refused"),
    [
        # the pan's bottom is at 200 mm, and 5 mm in another part are no overlap: 35 mm are free, of
        # which 25 mm are enough for those who lack so little
        (150, "46 mm", ""),
        (170, "25 mm", "letting the seat go 46 mm lower would put pan 16 mm into floor"),
        (200, "", "letting the seat go 46 mm lower would put pan 46 mm farther into floor"),
    ],
)
def test_a_seat_is_proposed_to_go_no_lower_than_to_the_floor(tmp_path, capsys, top, lower, refused):
    swap = of_figures(tmp_path) | {"at_least: 150": "at_least: 450"}
    floor = {"floor": ([-500, -500, top - 50], [500, 500, top])}
    path = write_toy(tmp_path, people=PEOPLE, swap=swap, boxes=floor)
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert (
        f"Letting the seat go {lower} lower takes" in said if lower else "lower takes" not in said
    )
    assert refused in said.replace("Letting", "letting") and ("would put" in said) == bool(refused)
    assert ("Not proposed: " in said) == (not lower)


def test_a_part_that_is_looked_over_is_proposed_to_be_lowered_by_what_eyes_are_too_low(tmp_path):
    """The eyes that are lowest by less than 100 mm too low come to the line over the lowered panel."""
    asked = "{name: view, check: eye_height, below: 60, above: 60}"
    view = "{name: nose, check: view_over, parts: [panel], down: 9}"
    path = write_toy(tmp_path, people=PEOPLE, swap={asked: view})
    result = wb.run(load_study(path)).population
    column = [one.check for one in result.requirements].index("view_over")
    lack = -result.margin[:, column]
    assert 0 < lack.max() < 0.1
    lower = next(gain for gain in result.gains if gain.words.startswith("moving panel"))
    assert lower.words == f"moving panel {np.ceil(1000 * lack.max()):.0f} mm down"
    assert lower.after == lower.joint_after == 1.0 and lower.margin_rate == pytest.approx(1.0)


def test_a_part_is_not_tried_where_it_would_come_up_through_everybody(tmp_path):
    """A slab that belongs to the roof lies 10 mm below the top of the pan. The roof would have to go
    up by 46 mm for five people's heads; the slab would then be 26 mm deep in all thighs."""
    swap = of_figures(tmp_path) | {
        "at_least: 150}": "at_least: 450}\n  - {name: inside, check: contact, at_most: 10}"
    }
    path = write_toy(tmp_path, people=PEOPLE, swap=swap)
    slab = [[x, y, z] for x, y, z in [100, -200, 240] + [200, 400, 50] * BOX]
    mesh = tmp_path / "environments" / "toy" / "toy.obj"
    lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in slab]
    count = mesh.read_text().count("\nv ") + 1
    lines += [f"f {a} {b} {c}" for a, b, c in (BOX_FACES + count).tolist()]
    mesh.write_text(mesh.read_text() + "\n".join(lines) + "\n")
    said = []
    found = accommodation(load_study(path), say=said.append)
    tried = [line for line in said if line.startswith("trying ")]
    assert found.served.sum() == 1 and tried
    assert not [line for line in tried if "roof 46" in line], tried
    limits = [one.gain.limit for one in found.tried if "roof" in one.gain.words]
    assert limits and all("46 mm up would put roof" in limit for limit in limits)


def test_nobody_is_proposed_to_move_what_he_sits_on(tmp_path):
    """More head room than there is, to the roof alone and to the back of the seat too."""
    roof = "segments: [H], parts: [roof], at_least: 150"
    for parts, things in (("[roof]", {"roof"}), ("[roof, back]", set())):
        path = write_toy(
            tmp_path, people=PEOPLE, swap={roof: f"segments: [H], parts: {parts}, at_least: 450"}
        )
        gains = wb.run(load_study(path)).population.gains
        moved = {gain.words.split()[1] for gain in gains if gain.words.startswith("moving")}
        assert moved & {"roof,", "roof", "2"} == things, [gain.words for gain in gains]


def test_a_population_is_told_that_the_seat_s_part_is_not_where_its_plane_is(tmp_path):
    """The pan's top is at 300 mm: with the seat reference point 40 mm higher people sit in the air."""
    path = write_toy(tmp_path, people=3)
    assert "is 30 mm clear of 'pan'" not in " ".join(wb.run(load_study(path)).warnings)
    room = tmp_path / "environments/toy/environment.yaml"
    room.write_text(room.read_text().replace("srp: [0, 0, 300]", "srp: [0, 0, 340]"))
    told = wb.run(load_study(path)).warnings
    assert any("is 30 mm clear of 'pan', the cushion of seat 'pilot'" in line for line in told)
    assert any(line.startswith("person ") for line in told)


def test_a_seat_that_people_have_moved_is_looked_for_where_they_have_it(tmp_path):
    """The eyes come to 1,250 mm in a seat that rises by up to 300 mm."""
    path = write_toy(tmp_path, people=3)
    room = tmp_path / "environments/toy/environment.yaml"
    text = room.read_text().replace("up: [0, 0]", "up: [0, 300]")
    room.write_text(text.replace("eye: [100, 0, 1050]", "eye: [100, 0, 1250]"))
    result = wb.run(load_study(path))
    assert result.population.seat[:, 1].min() > 0.05
    assert "seat reference point" not in " ".join(result.warnings)


def test_nothing_is_proposed_where_the_control_is_farther_than_two_moves_go(tmp_path):
    path = write_toy(tmp_path, knob=1250, people=PEOPLE, swap=of_figures(tmp_path))
    result = wb.run(load_study(path)).population
    assert result.gains == () and not result.served.any()
    assert "nor two of them together" in " ".join(population_lines(result))
