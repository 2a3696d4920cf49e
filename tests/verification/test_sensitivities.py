"""What is shown of a sensitivity without a question mark, beside finite differences with a step ten times
smaller.

Models of the gallery, and mechanisms with contact that are drawn: four-bars with one to three loose joints,
slider-cranks with a loose pin or guide, pendulums in loose bearings, discs thrown on a slope. Of each, some
numbers that are drawn as well. docs/sensitivity.md has the counts.
"""

from __future__ import annotations

import pytest

import vfife
from loose import made_up
from sensitivities import Outside, outside

pytestmark = pytest.mark.verify

GALLERY = {
    "block_on_incline": {}, "double_pendulum": {"duration": 1.0}, "four_bar": {"turns": 0.1},
    "four_bar_case_b": {"turns": 1.0},
    "four_bar_case_c": {"turns": 1.0}, "four_bar_ideal": {"turns": 1.0}, "journal_in_bearing": {},
    "quick_return": {"turns": 1.0},
    "six_bar_press": {"turns": 1.0}, "slider_crank": {"turns": 1.0},
    "slider_crank_loose_guide": {"turns": 1.0},
    "slider_crank_loose_pin": {"turns": 1.0},
}  # fmt: skip
# Two samples of some 300 derivatives each, one for each core: a share of one in a hundred cannot be judged by
# fewer.
FEW, SEEDS, GROUPS = 6, 96, 2
ALLOWED = 0.01  # of what is shown: four step sizes may agree by chance on what is not so


def told(name: str, found: Outside) -> None:
    """A line of the table of counts, and what is wrong."""
    print(
        f"| {name} | {found.derivatives} | {found.changes} | {found.unknown} | {len(found.wrong)} |",
        *found.wrong,
        sep="\n    ",
        flush=True,
    )


@pytest.mark.parametrize("name", GALLERY)
def test_what_is_shown_of_the_gallery_holds_the_truth(name):
    found = outside(vfife.load(f"examples/{name}.toml"), 2 * FEW, seed=1, **GALLERY[name])
    told(name, found)
    assert found.wrong == []


@pytest.mark.parametrize("group", range(GROUPS))
def test_what_is_shown_of_drawn_mechanisms_holds_the_truth(group):
    every = Outside()
    for seed in range(1000 + group, 1000 + SEEDS, GROUPS):
        found = outside(made_up(seed), FEW, seed=seed)
        every.derivatives, every.changes = (
            every.derivatives + found.derivatives,
            every.changes + found.changes,
        )
        every.unknown, every.wrong = every.unknown + found.unknown, every.wrong + found.wrong
    told(f"drawn, {SEEDS // GROUPS} of them", every)
    assert every.shown >= 200
    assert len(every.wrong) <= ALLOWED * every.shown
