"""Hands at controls are drawn as they hold them, in pictures and in pages; nothing else changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from workbench.draw.camera import standard_view
from workbench.draw.closed_hands import closed_hands
from workbench.draw.lines.arcs import outline_arcs
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.web.views import body_view, scene_view
from workbench.model.surroundings import move_parts

ARM = {"RS": {"flexion": 50}, "RE": {"flexion": 60}}


@pytest.fixture(scope="module")
def placed():
    body = wb.load_body("adult_male")
    return wb.place(body, wb.pose(body, ARM))


@pytest.fixture(scope="module")
def holding(placed):
    """The trainer with its throttle brought into the palm of the right hand."""
    trainer = wb.load_environment("trainer")
    throttle = next(one for one in trainer.controls if one.name == "throttle")
    arm = wb.limb(placed.body, "right hand", grip="grasp")
    world = placed.world_from_segment[0, arm.end]
    palm = world[:, :3] @ arm.tip[0] + world[:, 3]
    moved = move_parts(trainer, throttle.own_parts, palm - throttle.at)
    return replace(moved, controls=(replace(throttle, at=tuple(palm.tolist())),))


def depths(environment, centre, radius):
    """(S,) [m] how far spheres are from points all over the throttle lever, 1 mm apart and less."""
    corners = environment.triangle_corners(environment.part_index("throttle_lever"))
    share = np.random.default_rng(1).dirichlet(np.ones(3), 400)
    points = np.einsum("ps,tsi->tpi", share, corners).reshape(-1, 3)
    return np.linalg.norm(centre[:, None] - points, axis=2).min(axis=1) - radius


def test_a_hand_at_a_lever_is_drawn_around_it_and_not_pierced_by_it(placed, holding):
    (hand,) = closed_hands(placed, 0, holding)
    own = placed.body.spheres(hand.segment)
    straight = depths(holding, placed.centres[0, own], placed.body.radius[0, own])
    closed = depths(holding, hand.centre, hand.radius)
    assert straight.min() < -0.01  # the lever stands in the palm of the body's flat hand
    assert closed.min() > -2e-4
    fingers = closed[:40].reshape(5, 8).min(axis=1)
    assert np.sum(fingers < 2e-3) >= 3


def test_only_the_spheres_of_that_hand_are_others(placed, holding):
    shown = Scene((SceneBody(placed, holds=holding),), holding).spheres
    plain = Scene((SceneBody(placed),), replace(holding, controls=())).spheres
    (hand,) = closed_hands(placed, 0, holding)
    kept = np.flatnonzero(placed.body.sphere_segment != hand.segment)
    assert np.array_equal(shown.centre[: len(kept)], plain.centre[kept])
    assert np.array_equal(shown.centre[len(kept) :], hand.centre)
    assert len(plain.radius) == len(placed.body.sphere_names)


def test_an_outline_has_the_closed_hand(placed, holding):
    shown = Scene((SceneBody(placed, holds=holding),), holding)
    (hand,) = closed_hands(placed, 0, holding)
    arcs = outline_arcs(shown, standard_view("left", shown.bounds, width=300, height=300))
    own = len(shown.spheres.radius) - len(hand.radius)
    assert np.any(arcs.sphere >= own)


def test_a_hand_that_is_not_at_a_control_is_drawn_as_the_body_has_it(placed, holding):
    (control,) = holding.controls
    away = replace(control, at=(control.at[0] + 0.03, *control.at[1:]))
    assert closed_hands(placed, 0, replace(holding, controls=(away,))) == ()
    assert closed_hands(placed, 0, None) == ()


def test_a_turnable_picture_shows_the_same_hand_and_has_it_red_where_it_fails(placed, holding):
    (hand,) = closed_hands(placed, 0, holding)
    (view,) = scene_view(Scene((SceneBody(placed, holds=holding),), holding)).bodies
    assert np.array_equal(view.centres[0, -len(hand.radius) :], hand.centre)
    assert len(view.spheres) == len(view.segment) == len(view.radius) == view.centres.shape[1]
    first = placed.body.spheres(hand.segment).start
    failing = body_view(placed, "she", "warm", failing=[0, first], environment=holding).failing
    count = len(view.radius)
    assert failing == (0, *range(count - len(hand.radius), count))


def test_a_body_without_hands_and_one_without_controls_are_drawn_as_they_are(holding):
    dog = wb.load_body("dog")
    standing = wb.place(dog, wb.pose(dog, {}))
    assert closed_hands(standing, 0, holding) == ()


def test_a_cut_open_cockpit_is_drawn_with_the_same_hand(placed, holding):
    (hand,) = closed_hands(placed, 0, holding)
    shown = Scene((SceneBody(placed, holds=holding),), replace(holding, controls=()))
    assert np.array_equal(shown.spheres.centre[-len(hand.radius) :], hand.centre)
