"""Two designs with the same people: paired shares by hand, who gains and who loses, files, pages,
faults."""

from __future__ import annotations

import csv
import io
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.accommodations import made, result_of, shown_of, trainer_people
from tests.conftest import ROOT
from tests.test_accommodation_page import FLAPS, KNEE, parsed, text_of
from workbench import InputError, compare
from workbench.body.people.proportions import paired_share, proportion_interval
from workbench.cli import main
from workbench.draw.web.packing import Packing
from workbench.model.comparison import Judged
from workbench.model.result import ChangedPerson
from workbench.report.comparison.page import (
    change_sentence,
    changed_picture,
    comparison_headline,
    comparison_tables,
    person_to_show,
    write_comparison,
)
from workbench.report.folder import write_report
from workbench.study.accommodation.compare import evaluate_people


def paired(both, gained, lost, neither, **options):
    """From the counts of the four kinds of people."""
    was = np.repeat([True, False, True, False], [both, gained, lost, neither])
    now = np.repeat([True, True, False, False], [both, gained, lost, neither])
    return paired_share(was, now, **options)


@pytest.mark.parametrize(
    ("counts", "difference", "low", "high"),
    [
        ((20, 12, 2, 16), 0.2, 0.0562, 0.3292),
        ((36, 12, 2, 0), 0.2, 0.0569, 0.3404),
        ((53, 1, 0, 0), 0.0185, -0.0496, 0.0977),
    ],
)
def test_the_interval_is_that_of_newcombe_1998(counts, difference, low, high):
    found = paired(*counts)
    assert (found.difference, found.low, found.high) == pytest.approx(
        (difference, low, high), abs=5e-5
    )


def test_the_interval_worked_by_hand():
    # 30 both, 6 gained, 2 lost, 12 neither of 50: after 36/50, before 32/50 Wilson: 0.5833 to
    # 0.8253 and 0.5014 to 0.7586 cross product 30 x 12 - 6 x 2 = 348, less 25 for continuity = 323;
    # phi = 323 / sqrt(36 x 14 x 32 x 18) = 0.5995 down: sqrt(0.1367^2 - 2 x 0.5995 x 0.1367 x
    # 0.1186 + 0.1186^2) = 0.1154 up, from 0.1053 and 0.1386 likewise: 0.1131
    found = paired(30, 6, 2, 12)
    assert (found.difference, found.low, found.high) == pytest.approx(
        (0.08, -0.0354, 0.1931), abs=1e-4
    )


def test_chance_is_that_of_a_fair_coin():
    assert paired(20, 12, 2, 16).chance == pytest.approx(2 * (1 + 14 + 91) / 2**14)
    assert paired(5, 1, 0, 5).chance == 1
    assert paired(5, 6, 0, 5).chance == pytest.approx(2 / 64)
    assert paired(5, 3, 3, 5).chance == 1
    assert paired(5, 0, 0, 5).chance == 1


@given(st.lists(st.integers(0, 30), min_size=4, max_size=4).filter(any))
def test_turning_before_and_after_round_turns_the_interval_round(counts):
    both, gained, lost, neither = counts
    one = paired(both, gained, lost, neither)
    two = paired(both, lost, gained, neither)
    assert (one.low, one.high, one.difference) == pytest.approx(
        (-two.high, -two.low, -two.difference), abs=1e-12
    )
    assert one.chance == two.chance
    assert -1 <= one.low <= one.difference <= one.high <= 1


@given(
    st.lists(st.tuples(st.booleans(), st.booleans(), st.integers(1, 9)), min_size=1, max_size=40)
)
def test_weights_count_in_shares_and_sum_up(rows):
    was, now, weight = (np.array(column) for column in zip(*rows, strict=True))
    found = paired_share(was, now, weight=weight)
    assert found.before == pytest.approx(proportion_interval(was, weight=weight).share)
    assert found.after == pytest.approx(proportion_interval(now, weight=weight).share)
    assert found.both + found.gained + found.lost + found.neither == pytest.approx(1)
    assert found.gainers == int((~was & now).sum())


def test_a_wider_confidence_gives_a_wider_interval():
    narrow = paired(30, 6, 2, 12, confidence=0.8)
    wide = paired(30, 6, 2, 12, confidence=0.99)
    assert wide.low < narrow.low < narrow.high < wide.high


@pytest.mark.parametrize(
    ("was", "now", "options", "told"),
    [
        ([True], [True, False], {}, "person by person"),
        ([], [], {}, "person by person"),
        ([True], [True], {"weight": [0.0]}, "positive"),
        ([True], [True], {"confidence": 1.0}, "between 0 and 1"),
    ],
)
def test_what_cannot_be_paired_is_told(was, now, options, told):
    with pytest.raises(InputError, match=told):
        paired_share(np.array(was, dtype=bool), np.array(now, dtype=bool), **options)


@pytest.fixture(scope="module")
def before():
    """Ten people: flaps are missed by four, the knee by three, by one of them both."""
    flaps = np.array([-41, -20, -5, -1, 5, 10, 20, 30, 40, 50]) / 1000
    knee = np.array([-2, 1, 2, 3, -3, -12, 30, 40, 50, 60]) / 1000
    return result_of(made(trainer_people(10), [FLAPS, KNEE], np.stack([flaps, knee], axis=1)))


@pytest.fixture(scope="module")
def after(before):
    """The flaps 21 mm nearer, the knee 45 mm tighter for the last four."""
    found = before.population
    margin = found.margin + np.array([0.021, 0.0])
    margin[6:, 1] -= 0.045
    made_up = result_of(made(found.people, found.requirements, margin))
    return replace(made_up, study=replace(made_up.study, name="nearer", title="Flaps nearer"))


def test_who_gains_and_who_loses_by_hand(before, after):
    found = compare(before, after)
    assert found.gained == (1, 2, 3)
    assert found.lost == (6, 7)
    assert [(g.name, g.gainers, g.losers, g.count) for g in found.groups] == [
        ("everybody", 3, 2, 10),
        ("men", 3, 0, 5),
        ("women", 0, 2, 5),
    ]
    assert [(p.name, p.gainers, p.losers) for p in found.pairs] == [
        ("reach flaps", 3, 0),
        (KNEE.name, 0, 2),
    ]
    assert comparison_headline(found).startswith(
        "40 % of 10 people fit before and 50 % after, +10 points (95 % interval −29 to +45)"
    )
    assert "3 people gain and 2 people lose (exact McNemar test: p = 1)." in comparison_headline(
        found
    )


def test_what_was_changed_between_two_designs_is_told(before, after):
    environment = after.study.environment.moved({"left_stick": [0.02, 0, 0]})
    flaps = environment.control("flaps")
    x, y, z = flaps.at
    nearer = replace(flaps, at=(x - 0.032, y, z))
    controls = tuple(nearer if one is flaps else one for one in environment.controls)
    criteria = tuple(
        replace(one, at_least=one.at_least + 0.01) if one.check == "clearance" else one
        for one in after.study.criteria
    )
    study = replace(
        after.study, environment=replace(environment, controls=controls), criteria=criteria
    )
    found = compare(
        before, replace(after, study=study, population=replace(after.population, study=study))
    )
    by_name = {words.split(":")[0]: words for words in found.changes}
    was, now = (f"{1000 * at:.1f}".removesuffix(".0") for at in (x, x - 0.032))
    flaps = "place of control flaps"
    assert by_name[flaps].startswith(f"{flaps}: {was}, ") and "control flaps" not in by_name
    assert f"→ {now}, " in by_name[flaps]
    assert "place of part left_stick" in by_name and "place of control left_stick" in by_name
    clear = [one for one in criteria if one.check == "clearance"]
    assert len(found.changes) == 3 + len(clear)
    name, least = clear[0].name, 1000 * clear[0].at_least
    assert by_name[f"criterion “{name}”"] == (  # what changed, and nothing that did not
        f"criterion “{name}”: at least {least - 10:g} mm → at least {least:g} mm"
    )
    assert compare(before, before).changes == ()


def test_each_who_changes_is_told_with_the_margin_in_both(before, after):
    found = compare(before, after)
    tall = 1000 * before.population.people.column("stature")
    assert change_sentence(found, 1) == (
        f"male 2, a man of {tall[1]:,.0f} mm: “reach flaps” was 20 mm short, 1 mm to spare now."
    )
    assert change_sentence(found, 6) == (
        f"female 2, a woman of {tall[6]:,.0f} mm: “right knee clear of the panel” is 15 mm short, 30 mm to spare "
        "before."
    )


def test_a_reach_that_was_looked_for_no_farther_has_at_least_that(before, after):
    margin = after.population.margin.copy()
    margin[1, 0] = 0.2
    wide = replace(after, population=replace(after.population, margin=margin))
    assert change_sentence(compare(before, wide), 1).endswith(
        "“reach flaps” was 20 mm short, at least 200 mm to spare now."
    )


def test_a_design_compared_with_itself_changes_nothing(before):
    found = compare(before, before)
    assert found.gained == found.lost == ()
    assert comparison_headline(found) == (
        "40 % of 10 people fit before and 40 % after: the same people, nobody gains and nobody loses."
    )
    assert all(pair.low <= 0 <= pair.high and pair.chance == 1 for pair in found.pairs)


def test_a_requirement_of_one_side_only_counts_there_and_is_told(before):
    found = before.population
    alone = result_of(made(found.people, [FLAPS], found.margin[:, :1]))
    found = compare(before, alone)
    assert found.only_before == (KNEE.name,)
    assert found.gained == (4, 5)
    assert (
        "“right knee clear of the panel” was 3 mm short, is not asked for now"
        in change_sentence(found, 4)
    )


def people_of(judgement, **changes):
    return replace(judgement, **changes)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            lambda j: Judged(
                j.name,
                j.title,
                j.requirements,
                j.labels[:9],
                j.sex[:9],
                j.weight[:9],
                j.stature[:9],
                j.margin[:9],
                j.units,
                "x",
            ),
            "10 people in the first, 9 in the second",
        ),
        (
            lambda j: replace(j, sex=1 - j.sex),
            r"person 1 \(male 1\) is male in the first, female in the second",
        ),
        (
            lambda j: replace(j, stature=j.stature + 0.001),
            r"person 1 \(male 1\) has a stature of 1[\d.]+ mm",
        ),
        (
            lambda j: replace(j, weight=j.weight * 2),
            "has the weight 1 in the first, 2 in the second",
        ),
        (lambda j: replace(j, who="other"), "not in all measures"),
        (
            lambda j: replace(j, requirements=("a", "b")),
            "no requirement in common to compare: the first asks for reach fl",
        ),
    ],
)
def test_different_people_are_told_with_the_first_difference(before, change, told):
    one = evaluate_people(before)
    with pytest.raises(InputError, match=told):
        compare(one, change(one))


def test_the_page_and_tables_are_whole_and_the_same_each_time(before, after, tmp_path):
    rows = write_comparison(compare(before, after), tmp_path / "one")
    write_comparison(compare(before, after), tmp_path / "two")
    names = {"manifest.json", "comparison.json", "people.csv", "requirements.csv", "report.html"}
    assert {p.name for p in (tmp_path / "one").iterdir()} == names
    for name in names:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    html = (tmp_path / "one/report.html").read_text()
    parsed(html)
    assert "Who gains" in text_of(html) and "“reach flaps” was 20 mm short" in text_of(html)
    assert [(c.change, c.row) for c in rows.changed] == [
        ("gained", 1),
        ("gained", 2),
        ("gained", 3),
        ("lost", 6),
        ("lost", 7),
    ]


def test_the_table_of_people_has_both_margins_of_everybody(before, after):
    rows = list(
        csv.DictReader(io.StringIO(str(comparison_tables(compare(before, after))["people.csv"])))
    )
    assert len(rows) == 10
    assert [row["change"] for row in rows] == [
        "left out",
        *["gained"] * 3,
        *["left out"] * 2,
        "lost",
        "lost",
        "fits",
        "fits",
    ]
    assert (rows[1]["reach flaps: before [mm]"], rows[1]["reach flaps: after [mm]"]) == (
        "-20.0",
        "1.0",
    )


@pytest.fixture
def folders(before, after, tmp_path):
    """Both results as `workbench run` leaves them."""
    for name, result in (("before", before), ("after", after)):
        write_report(result, tmp_path / name)
    return tmp_path


def test_the_command_compares_folders_as_the_arrays_are_compared(folders, before, after, capsys):
    said = [
        str(folders / "before"),
        str(folders / "after/result.json"),
        "--out",
        str(folders / "both"),
    ]
    assert main(["compare", *said]) == 0
    assert capsys.readouterr().out.splitlines()[0] == comparison_headline(compare(before, after))
    assert main(["compare", *said, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert [row["row"] for row in data["changed"]] == [1, 2, 3, 6, 7]
    assert data["provenance"]["before"] == {"study": "0" * 64}


def test_what_is_no_accommodation_is_told_and_nothing_is_written(folders, capsys, tmp_path):
    out = tmp_path / "both"
    for one, two, told in [
        (str(folders / "before"), str(folders / "nowhere.json"), "no such file"),
        (str(folders / "before"), "trainer_clearance", "is no study of a population"),
        ("no_such_study", str(folders / "before"), "no_such_study"),
    ]:
        assert main(["compare", one, two, "--out", str(out)]) == 3
        assert told in capsys.readouterr().err
        assert not out.exists()
    assert (
        main(
            [
                "compare",
                str(folders / "before"),
                str(folders / "after"),
                "--out",
                str(folders / "before"),
            ]
        )
        == 3
    )
    assert "holds a result, not a comparison" in capsys.readouterr().err


def test_compare_is_public():
    assert {"compare", "Comparison"} <= set(wb.__all__)


def test_the_document_s_block_prints_what_it_says(capsys):
    text = (ROOT / "docs" / "comparison.md").read_text()
    exec(compile(re.search(r"```python\n(.*?)```", text, re.S)[1], "comparison.md", "exec"), {})
    assert capsys.readouterr().out.strip() == re.search(r"```text\n(.*?)\n```", text, re.S)[1]


def test_who_gains_is_shown_in_both_designs_with_what_is_short_and_to_spare(before, after):
    found = compare(before, after)
    assert person_to_show(found) == (1, "reach flaps")
    one = shown_of(wb.load_body("bubbleman"), 1, 0, before.population.requirements)
    packing = Packing()
    html = changed_picture(found, ChangedPerson(1, one, one), packing)
    (view,) = packing.views
    assert view["states"] == ["before", "after"]
    marks = [(mark["text"], mark["failing"], mark["state"]) for mark in view["marks"]]
    assert marks == [("20 mm short", True, 0), ("1 mm to spare", False, 1)]
    assert "was 20 mm short, 1 mm to spare now" in html
    assert html.count("data:image/png") == 2
