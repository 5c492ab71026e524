"""Overlaps of a population that no criterion asks about, against the contacts of each person alone."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.test_bench_people import FEW, few_people
from workbench.contact.collide import contacts, self_contacts
from workbench.study.accommodation.accommodation import population_question
from workbench.study.accommodation.overlaps import (
    join_overlaps,
    overlap_warnings,
    people_overlaps,
    summed_overlaps,
)
from workbench.study.bench.crowd import crowd_question, open_crowd, settled
from workbench.study.bench.state import open_study
from workbench.study.situation import with_hands


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return few_people(tmp_path_factory.mktemp("overlaps"))


@pytest.fixture(scope="module")
def there(path):
    """The people by setting, with the hands at rest, as a run finds them."""
    opened = open_study(wb.load_study(path))
    crowd = open_crowd(opened)
    question = crowd_question(opened, crowd, opened.start)
    return settled(crowd, question, opened.start, np.arange(FEW)).places


def alone(situation):
    """By segment and part, or other segment, how deep one person is beyond what is allowed, where
    that is more than the fit error."""
    environment = situation.environment_moved
    posed = with_hands(situation)
    error = situation.body.fit_error[0, :, 1]
    deep = {}
    found = contacts(posed.placed, environment).deepest()
    for row in range(len(found)):
        n, k = int(found.segment[row]), int(found.part[row])
        if found.excess[row] - error[n] > 5e-5:
            deep[n, k, -1] = found.excess[row]
    own = self_contacts(posed.placed).deepest()
    for row in range(len(own)):
        n, m = int(own.segment[row]), int(own.other_segment[row])
        if own.excess[row] - error[n] - error[m] > 5e-5:
            deep[n, -1, m] = own.excess[row]
    return deep


def asked_pairs(situation):
    """Pairs of a segment and a part that a clearance or contact measures, and subparts' segments."""
    body = situation.body
    environment = situation.environment
    pairs = set()
    for one in situation.place.criteria:
        if one.check not in ("clearance", "contact") or one.subparts:
            continue
        for segment in one.segments:
            pairs |= {(body.segment(segment), environment.part_index(part)) for part in one.parts}
    return pairs


def test_overlaps_are_the_contacts_of_each_person_that_nothing_asks_about(there):
    count = 0
    for rows, situations in there:
        found = people_overlaps(situations)
        for at in range(len(rows)):
            one = situations[0].rows(np.array([at]))
            asked = asked_pairs(one)
            wanted = {key: deep for key, deep in alone(one).items() if key[:2] not in asked}
            mine = found.pair[:, 0] == at
            got = dict(zip(map(tuple, found.pair[mine, 1:]), found.depth[mine], strict=True))
            assert got.keys() == wanted.keys()
            assert all(got[key] == pytest.approx(wanted[key], abs=1e-9) for key in got)
            count += len(got)
    assert count > 0


def test_a_run_counts_the_people_who_overlap_and_says_so(path, there):
    study = wb.load_study(path)
    result = wb.run(study)
    found = result.population
    overlaps = join_overlaps([people_overlaps(two) for _, two in there], [one for one, _ in there])
    place = population_question(study).place
    summed = summed_overlaps(overlaps, found.body, place.environment, found.people.weight)
    assert found.overlaps == summed and len(summed) > 0
    first = summed[0]
    words = f"{first.people} of {FEW} people: {first.segment} in {first.part}"
    assert any(line.startswith(words) for line in found.warnings)
    assert first.people == max(one.people for one in summed)
    entered = np.unique(overlaps.pair[:, 0])
    clear = found.served & ~np.isin(np.arange(FEW), entered)
    np.testing.assert_array_equal(found.clear, clear)
    assert found.shares[0].clear == pytest.approx(np.mean(clear))


def test_a_criterion_that_asks_about_an_overlap_takes_its_warning(path, there):
    study = wb.load_study(path)
    before = {(one.segment, one.part) for one in wb.run(study).population.overlaps if one.part}
    segment, part = sorted(before)[0]
    body = study.roles[0].body
    mnemonic = body.segments[body.segment_names.index(segment)]
    text = path.read_text().replace(
        "criteria:\n",
        f"criteria:\n  - {{name: asked, check: contact, segments: [{mnemonic}], parts: [{part}]}}\n",
    )
    other = path.with_name("asked.yaml")
    other.write_text(text)
    after = {(one.segment, one.part) for one in wb.run(wb.load_study(other)).population.overlaps}
    assert (segment, part) not in after


def test_only_so_many_pairs_have_a_sentence_of_their_own(there):
    situation = there[0][1][0]
    overlaps = people_overlaps(there[0][1])
    some = summed_overlaps(overlaps, situation.body, situation.environment, np.ones(FEW))
    lines = list(overlap_warnings(some[:1] * 7, FEW, tuple(f"{9000 + k}" for k in range(FEW))))
    assert f"(person {9000 + some[0].person})" in lines[0]
    assert len(lines) == 6 and lines[-1].startswith("2 more pairs overlap")
    assert list(overlap_warnings((), FEW)) == []
