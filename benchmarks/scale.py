"""How fast and how surely people become bodies: python -m benchmarks.scale [BODY] [people] [detail]

CPU seconds of this process on a warm body (its space of shapes worked out, kernels compiled); the
goals stand beside the figures. People: ANSUR II as figures, seed 1, men unless the body's name says
otherwise.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from time import process_time

import numpy as np

import workbench as wb
from workbench.body.scaling.measure import MEASURES, measure
from workbench.body.scaling.scale import morph_to, scale, scale_many
from workbench.files.populations import load_population_model
from workbench.study.crowd import SHOWN
from workbench.study.persons import person_body

EVERYBODY = 6068


def seconds(work: Callable[[], object]) -> float:
    """CPU seconds of one call."""
    began = process_time()
    work()
    return process_time() - began


def main(name: str, people: int, detail: str | None) -> None:
    """Print one table."""
    model = load_population_model("ansur2")
    body = morph_to(wb.load_body(name), detail)
    sex = "female" if "female" in name else "male"
    drawn = wb.draw_people(model, people, seed=1, men=float(sex == "male")).of(SHOWN)
    rows = [dict(zip(SHOWN, row.tolist(), strict=True)) for row in drawn.measures]
    first = seconds(lambda: scale(body, rows[0]))
    each = []
    misses = []
    refused = []
    for row in rows[: min(100, people)]:
        try:
            each.append(seconds(lambda row=row: scale(body, row)))  # type: ignore[misc]
        except wb.InputError:
            continue
    began = process_time()
    made = list(scale_many(body, rows))
    batch = (process_time() - began) / people
    for one, row in zip(made, rows, strict=True):
        if isinstance(one, wb.InputError):
            refused.append(str(one))
        else:
            misses.append(max(abs(value - row[key]) for key, value in measure(one, SHOWN).items()))
    some = [one for one in made if isinstance(one, wb.Body)][:30]
    taken = seconds(lambda: [measure(one) for one in some]) / len(some)
    whole = (
        seconds(lambda: [person_body(body, model, sex=sex, measures=row) for row in rows[:20]]) / 20
    )
    print(f"{body!r}, {len(SHOWN)} measures, {people} people ({sex})")
    print(f"{'first person (the space of shapes worked out)':<58}{first * 1e3:9.1f} ms")
    print(
        f"{f'one person to {len(SHOWN)} measures, median':<58}{np.median(each) * 1e3:9.1f} ms   goal 10"
    )
    print(f"{'the same, the others near those of such people':<58}{whole * 1e3:9.1f} ms")
    print(f"{'one of many, from the person most like him':<58}{batch * 1e3:9.1f} ms")
    print(
        f"{f'{EVERYBODY} people, one core':<58}{batch * EVERYBODY:9.1f} s    goal 120 (60 on two)"
    )
    print(
        f"{f'{len(MEASURES)} measures of a body':<58}{taken * 1e3:9.1f} ms   goal 5 (35 measures)"
    )
    print(f"{'largest miss on a given measure':<58}{1e3 * max(misses):9.5f} mm   goal 1 (aim 0.05)")
    print(f"{'people refused':<58}{len(refused):9d} of {people}")
    for line in refused[:5]:
        print("   ", line)


if __name__ == "__main__":
    given = sys.argv[1:]
    main(
        given[0] if given else "bubbleman",
        int(given[1]) if len(given) > 1 else 500,
        given[2] if given[2:] else None,
    )
