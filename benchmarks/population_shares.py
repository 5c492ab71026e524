"""Joint shares of drawn people against measured ones: how wrong three ways of drawing people are.

    python -m benchmarks.population_shares [--splits 20] [--people 20000] [--chance 100] [--seed 1]

People of ANSUR II are split at random into halves. A Gaussian copula, a t copula (its degrees of
freedom are the likeliest for the sex) and the synthetic people of the workbench are fitted to one
half and tried on the other, both ways round. A rule is a set of limits of 3 to 8 measures.
Each line shows the share of the survey inside one, and for each way the mean error over the splits
in points of percent. The last columns are the standard error of such a mean, the rms error of
the workbench's people in one split, and the rms difference of the two halves themselves.
--chance adds rules drawn at random, of which the worst errors are shown.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from tests.population_shares import (
    RULES,
    Draw,
    HeldOut,
    Rule,
    chance_rules,
    gaussian,
    held_out,
    joint_shares,
    likeliest_freedom,
    synthetic,
    t_copula,
)
from workbench import load_population_model
from workbench.model.population import SEXES, Population

__all__ = ["main"]

FREEDOMS = (4, 6, 8, 12, 20, 30, 50, 80, 120, 200, 400)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--splits", type=int, default=20)
    parser.add_argument("--people", type=int, default=20_000)
    parser.add_argument("--chance", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


def main() -> None:
    """Print a table for each sex."""
    options = _options()
    people = load_population_model("ansur2").people
    assert people is not None
    rules = (*RULES, *chance_rules(options.chance, people.names, options.seed))
    for sex in SEXES:
        survey = people.of_sex(sex)
        freedom = likeliest_freedom(survey, FREEDOMS)
        ways: dict[str, Draw] = {
            "Gaussian": gaussian,
            f"t, {freedom:g} degrees": partial(t_copula, freedom=freedom),
            "workbench": synthetic,
        }
        found = {
            name: held_out(
                survey,
                rules,
                way,
                splits=options.splits,
                count=options.people,
                seed=options.seed,
            )
            for name, way in ways.items()
        }
        _show(sex, survey, rules, found)


def _show(
    sex: str, survey: Population, rules: Sequence[Rule], found: Mapping[str, HeldOut]
) -> None:
    """Print the table of one sex as Markdown."""
    shares = joint_shares(survey, survey, rules)
    last = found["workbench"]
    print(f"\n| {sex} | survey, % | {' | '.join(found)} | ± | rms | halves |")
    print("|---|" + "---:|" * (len(found) + 4))
    for r, rule in enumerate(rules[: len(RULES)]):
        means = " | ".join(f"{way.mean[r]:+.1f}" for way in found.values())
        rest = f"{last.error[r]:.1f} | {last.rms[r]:.1f} | {last.halves[r]:.1f}"
        print(f"| {rule.name} | {shares[r]:.1f} | {means} | {rest} |")
    for words, chosen in (("these", slice(len(RULES))), ("chance", slice(len(RULES), None))):
        if len(rules[chosen]):
            worst = " | ".join(f"{np.abs(way.mean[chosen]).max():.2f}" for way in found.values())
            print(f"| worst of {words} ({len(rules[chosen])}) | | {worst} | | | |", flush=True)


if __name__ == "__main__":
    main()
