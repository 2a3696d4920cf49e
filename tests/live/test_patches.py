"""Positions of sliders as patches: what is laid together is what assembly gives, to the bit, and what is not
is put into a group.
"""

import dataclasses
import itertools
import math
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from vfife import gallery
from vfife.errors import VfifeError
from vfife.live.page import patches
from vfife.live.page.patches import GROUP_COMBINATIONS, Assembler, fewer_positions, slider_patches
from vfife.live.page.sliders import POSITIONS, Slide, default_slides, number_at, parse_slides
from vfife.model.mechanism import StartSettings
from vfife.modelfile import dump, loads


def few(slide: Slide) -> Slide:
    """A slider with two positions: the model's own and an end."""
    places = sorted({slide.here, len(slide.values) - 1 if slide.here == 0 else 0})
    return dataclasses.replace(
        slide, values=tuple(slide.values[k] for k in places), here=places.index(slide.here)
    )


def same(one, other) -> bool:
    return bool((one.view(np.uint64) == other.view(np.uint64)).all())


def every_setting(found, mechanism):
    """Each setting as patches give it and as assembly does, with the numbers and the model file of both."""
    assembler = Assembler(mechanism, found.base.assembly.choice.step)
    for positions in itertools.product(*(range(len(slide.values)) for slide in found.slides)):
        wanted = assembler.at(found.slides, positions)
        assert wanted is not None
        yield (
            found.vector(positions),
            wanted.vector,
            found.model_file(positions),
            dump(wanted.assembly.mechanism),
        )


def test_patches_of_sliders_that_do_not_meet_combine_to_the_bit():
    mechanism = gallery.four_bar_case_c()
    slides = default_slides(mechanism)
    assert [slide.name for slide in slides] == [
        *(f"joint.{name}.clearance" for name in "BCD"), "driver.crank.speed", "friction", "restitution",
    ]  # fmt: skip
    found = slider_patches(mechanism, [few(slides[k]) for k in (1, 3, 5)])
    assert [group.sliders for group in found.groups] == [(0,), (1,), (2,)] and found.texts
    for numbers, wanted, text, model in every_setting(found, mechanism):
        assert same(numbers, wanted)
        assert text == model


def test_patches_that_do_not_combine_are_grouped():
    """Where journals are seated, the start depends on every clearance and on the speed at once."""
    mechanism = gallery.four_bar_case_c()
    mechanism.start = StartSettings(journals="seated")
    slides = [few(slide) for slide in default_slides(mechanism)]
    found = slider_patches(mechanism, [slides[1], slides[3], slides[4]])
    assert [group.sliders for group in found.groups] == [(0, 1), (2,)]
    for numbers, wanted, _, _ in every_setting(found, mechanism):
        assert same(numbers, wanted)
    apart = [numbers for numbers, *_ in every_setting(found, mechanism)]
    assert len({numbers.tobytes() for numbers in apart}) == len(apart)


def test_where_a_grid_would_be_too_coarse_one_slider_moves_at_a_time():
    """Five sliders of a seated start keep all their positions; two of them moved at once is no setting."""
    mechanism = gallery.four_bar_case_c()
    mechanism.start = StartSettings(journals="seated")
    slides = [few(slide) for slide in default_slides(mechanism)[:5]]
    found = slider_patches(mechanism, slides)
    (group,) = (group for group in found.groups if group.singly)
    assert group.sliders == (0, 1, 2, 3) and len(group.values) == 5
    assert "can differ from the model at a time: moving one returns the others" in found.notes[-1]
    assembler = Assembler(mechanism, found.base.assembly.choice.step)
    here = [slide.here for slide in found.slides]
    for s, slide in enumerate(found.slides):
        positions = tuple(1 - slide.here if k == s else one for k, one in enumerate(here))
        assert same(found.vector(positions), assembler.at(found.slides, positions).vector)
    with pytest.raises(ValueError):
        found.vector([1 - one for one in here])


def test_one_step_serves_all_positions_and_is_as_fine_as_each_asks_for():
    mechanism = gallery.four_bar_case_c()
    alone = slider_patches(mechanism, []).base.assembly.choice
    found = slider_patches(
        mechanism,
        [
            few(slide)
            for slide in parse_slides(
                mechanism, ["driver.crank.speed=500..1500rpm", "joint.C.clearance=0.02..0.2mm"]
            )
        ],
    )
    assert found.base.assembly.choice.outputs_every > alone.outputs_every
    assert found.base.assembly.choice.outputs == alone.outputs


def test_positions_that_no_model_may_have_are_left_out():
    mechanism = gallery.four_bar_case_b()
    found = slider_patches(mechanism, parse_slides(mechanism, ["joint.C.clearance=0.1..40mm"]))
    radius = mechanism.joints["C"].bearing_radius
    (slide,) = found.slides
    assert slide.values[-1] < radius
    assert "joint.C.clearance" in found.notes[0] and "left out, as the last of them: " in found.notes[0]
    assert not found.notes[0].endswith("."), "the note becomes a sentence where it is printed"


def test_ranges_are_read_with_their_units():
    mechanism = gallery.four_bar_case_c()
    (one,) = parse_slides(mechanism, ["joint.C.clearance=0.01..0.5mm"])
    assert (one.values[0], one.values[-1], one.values[one.here]) == (1e-5, 5e-4, 2e-4)
    (two,) = parse_slides(mechanism, ["joint.C.clearance = 10 µm .. 0.5 mm"])
    assert two.values == one.values
    (three,) = parse_slides(
        mechanism, ["joint.C.clearance=0.2..0.21mm"]
    )  # the last digit is none of the unit
    assert (three.values[0], three.values[-1]) == (2e-4, 2.1e-4)
    (speed,) = parse_slides(mechanism, ["driver.crank.speed=1000..2000 rpm"])
    assert speed.values[0] == pytest.approx(1000 * np.pi / 30, rel=1e-2)
    assert number_at(mechanism, "joint.C.contact.restitution") == (0.9, "1")


def test_sliders_of_clearances_have_the_same_factors_where_their_ranges_overlap():
    changes = [("joint.B.clearance", 20.5e-6), ("joint.C.clearance", 17e-6)]
    mechanism = loads(dump(gallery.four_bar_case_c()), set=changes)
    texts = ["joint.B.clearance=2..200um", "joint.C.clearance=10..40um", "driver.crank.speed=900..1100rpm"]
    *slides, speed = parse_slides(mechanism, texts)
    factors = [[value / slide.values[slide.here] for value in slide.values] for slide in slides]
    low, high = 10 / 17, 40 / 17
    assert (factors[1][0], factors[1][-1]) == (pytest.approx(low), pytest.approx(high))
    inner = [factor for factor in factors[0] if low * (1 - 1e-9) < factor < high * (1 + 1e-9)]
    assert inner == pytest.approx(factors[1], rel=1e-9) and len(inner) > 15
    assert (slides[0].values[0], slides[0].values[-1]) == (2e-6, 2e-4)
    assert speed == parse_slides(mechanism, texts[2:])[0]
    assert [slide.values[slide.here] for slide in slides] == [20.5e-6, 17e-6]
    thinned = fewer_positions((*slides, speed), [(0, 1, 2)])
    kept = [{round(value / one.values[one.here], 9) for value in one.values} for one in thinned[:2]]
    assert [len(one.values) for one in thinned] == [7, 5, 7]
    assert len(kept[0] & kept[1]) == 5 and {1.0, round(low, 9), round(high, 9)} <= kept[0] & kept[1]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("joint.C.clearance", "PATH=LOW..HIGH"),
        ("joint.C.clearance=0.01..0.2", 'Write "0.2 mm", or "0.2 m"'),
        ("joint.C.clearance=1mm", "PATH=LOW..HIGH"),
        ("joint.C.clearance=2..1mm", "empty"),
        ("joint.X.clearance=1..2mm", "there is no"),
        ("joint.C.clearanse=1..2mm", "clearance"),
        ("joint.C.bearing=1..2", "no number"),
        ("joint.C.clearance=1..2 kg", "length"),
        ("nothing.C=1..2", "no table or key"),
    ],
)
def test_a_slide_that_cannot_be_used_is_told_in_a_sentence(text, said):
    with pytest.raises(ValueError, match="--slide") as error:
        parse_slides(gallery.four_bar_case_c(), [text])
    assert said in str(error.value)


def test_what_has_no_motion_has_no_page():
    with pytest.raises(VfifeError, match="static"):
        slider_patches(gallery.toggle_press(), [])


def test_a_group_keeps_the_models_own_position_and_few_combinations():
    values = tuple(float(k) for k in range(31))
    slides = tuple(Slide(name, (name,), "1", values, here) for name, here in (("a", 7), ("b", 29)))
    thinned = fewer_positions(slides, [(0, 1)])
    assert [slide.values[slide.here] for slide in thinned] == [7.0, 29.0]
    assert [len(slide.values) for slide in thinned] == [20, 20]
    assert math.prod(len(slide.values) for slide in thinned) <= GROUP_COMBINATIONS
    (alone, _) = fewer_positions(slides, [(0,), (1,)])
    assert len(alone.values) == POSITIONS + 1 and alone.values[alone.here] == 7.0


@pytest.mark.parametrize(
    ("combinations", "together", "wanted"), [(400, 3, 7), (400, 4, POSITIONS + 1), (250, 3, POSITIONS + 1)]
)
def test_sliders_keep_all_positions_where_a_group_would_leave_fewer_than_seven(
    combinations, together, wanted, monkeypatch
):
    """The third root of 400 is 7.4, its fourth root 4.5, the third root of 250 is 6.3."""
    monkeypatch.setattr(patches, "GROUP_COMBINATIONS", combinations)
    slides = tuple(Slide(name, (name,), "1", tuple(map(float, range(31))), 7) for name in "abcd"[:together])
    thinned = fewer_positions(slides, [tuple(range(together))])
    assert [len(slide.values) for slide in thinned] == [wanted] * together


class Formula:
    """Stands for assembly: row 0 is the first slider's position, row 1 the second one's, and row 2 is not
    zero where both are ``meeting``.
    """

    def __init__(self, mechanism, step, before_assembly=None, *, meeting=()) -> None:
        self.mechanism, self.text, self.meeting = mechanism, dump(mechanism), meeting
        self.base = self.model((2, 2))

    def model(self, positions):
        both = all(position in self.meeting for position in positions)
        vector = np.array([*map(float, positions), float(both) * (1.0 + positions[0])])
        return SimpleNamespace(vector=vector, assembly=SimpleNamespace(mechanism=self.mechanism))

    def refine(self, slides) -> None:
        """Nothing to refine."""

    def at(self, slides, positions):
        return self.model(positions)

    model_or_reason = at


@pytest.mark.parametrize(
    ("meeting", "groups"),
    [((), [(0,), (1,)]), ((0, 4), [(0, 1)]), ((4,), [(0, 1)]), ((0,), [(0, 1)]), ((1, 3), [(0, 1)])],
)
def test_sliders_that_meet_at_an_end_or_between_the_ends_are_grouped(meeting, groups, monkeypatch):
    """Pairs are compared at both ends of their ranges; what meets only between them is found by settings of
    all sliders at once.
    """
    monkeypatch.setattr(patches, "Assembler", partial(Formula, meeting=meeting))
    slides = [Slide(name, (name,), "1", (0.0, 1.0, 2.0, 3.0, 4.0), 2) for name in "ab"]
    found = slider_patches(gallery.four_bar_ideal(), slides)
    assert [group.sliders for group in found.groups] == groups
    formula = Formula(gallery.four_bar_ideal(), None, meeting=meeting)
    for positions in itertools.product(range(5), range(5)):
        assert found.vector(positions).tolist() == formula.model(positions).vector.tolist()


@pytest.mark.parametrize("journals, falls", [("centred", True), ("seated", False)])
def test_a_page_says_that_journals_fall_at_its_start(journals, falls):
    mechanism = gallery.four_bar_case_b()
    mechanism.start = StartSettings(journals=journals)
    notes = " ".join(slider_patches(mechanism, []).json()["notes"])
    assert ("of the first turn may be those of the start, where the journals of C fall" in notes) == falls
    assert ('start.journals = "seated"' in notes) == falls
