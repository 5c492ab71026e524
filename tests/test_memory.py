"""Batches larger than the memory that is allowed for them go in pieces, and no answer shows it."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from workbench.contact import posed


def test_a_body_of_four_segments_and_ten_spheres_takes_624_bytes_a_pose(one_arm, monkeypatch):
    # 12 numbers for each of 4 segments, 3 for each of 10 spheres, 8 bytes each
    monkeypatch.setattr(posed, "MEMORY", 624 * 7 + 623)
    assert (len(one_arm.segments), len(one_arm.sphere_names)) == (4, 10)
    assert posed._at_a_time(one_arm) == 7
    monkeypatch.setattr(posed, "MEMORY", 1)
    assert posed._at_a_time(one_arm) == 1


@pytest.mark.parametrize("poses", [1, 99, 100, 101, 1000])
def test_a_large_batch_is_cut_by_the_bytes_that_its_placed_bodies_take(
    one_arm, random_arm, box_cab, poses, monkeypatch
):
    held = []

    def counted(placed, *args, **options):
        held.append(placed.centres.nbytes + placed.world_from_segment.nbytes)
        return wb.collides(placed, *args, **options)

    batch = random_arm(poses, 3)
    monkeypatch.setattr(posed, "collides", counted)
    monkeypatch.setattr(posed, "MEMORY", 624 * 100)
    hit = posed.posed_collides(one_arm, batch, box_cab)
    assert len(held) == -(-poses // 100)
    assert max(held) <= posed.MEMORY
    assert np.array_equal(hit, wb.collides(wb.place(one_arm, batch), box_cab))
