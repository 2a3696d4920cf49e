"""The page as a file: it asks for nothing from elsewhere, names in it are text, strokes follow their pins."""

import json
import math
import re

import numpy as np
import pytest

from live.pages import page_of, scripts_of
from model.test_kinds import CASES
from vfife import gallery
from vfife.live.page import strokes
from vfife.live.page.page import BROWSER, LARGEST
from vfife.live.page.page_model import page_model
from vfife.live.page.payload import payload as given
from vfife.live.page.payload import pin_of, place

RUNNING = [name for name in gallery.__all__ if getattr(gallery, name)().settings.analysis == "dynamic"]
EVIL = '</script><script>alert("x")</script><b onclick=1>&amp;<!--'


@pytest.mark.parametrize("name", ["squeezer", "four_bar_case_c"])
def test_a_page_is_small_and_needs_nothing(name):
    page = page_of(getattr(gallery, name)())
    assert len(page.encode()) < LARGEST
    text = page.replace("http://www.w3.org/2000/svg", "")  # the name of a language, which nobody fetches
    assert not re.search(
        r"https?://|//[a-z]+\.[a-z]+/|\bimport\(|@import|url\((?!#)|fetch\(|XMLHttpRequest|WebSocket|EventSource",
        text,
    )
    assert "default-src 'none'" in page
    assert not re.search(r"<(link|img|iframe|object|embed|base)\b|\ssrc=", text)


def test_names_are_text():
    mechanism = gallery.four_bar_case_b()
    mechanism.name, mechanism.note = EVIL, EVIL
    page = page_of(mechanism)
    assert EVIL not in page and 'alert("x")</script>' not in page
    assert scripts_of(page)["name"] == EVIL == scripts_of(page)["note"]
    assert page.count("</script>") == 2
    scripts = "".join(path.read_text("utf-8") for path in BROWSER.glob("*.js"))
    assert not re.search(
        r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\b|new Function", scripts
    )


def placed(point, pins, angles, size, way):
    """Where a point of a stroke is, by its numbers: the page's own formula in Python."""
    carrier, turner, *v = point
    first, second = map(np.array, pins)
    if carrier == strokes.BOTH_PINS:
        along = second - first
        across = np.array([-along[1], along[0]]) / (np.linalg.norm(along) or 1.0)
        return first + v[0] * along + (v[1] + size * v[3]) * across
    x, y = (v[axis] + size * v[2 + axis] + way[0] * v[4 + axis] + way[1] * v[6 + axis] for axis in (0, 1))
    angle = (0.0, *angles)[turner]
    c, s = math.cos(angle), math.sin(angle)
    return (first if carrier == strokes.FIRST_PIN else second) + (c * x - s * y, s * x + c * y)


@pytest.mark.parametrize("name", RUNNING)
def test_strokes_are_carried_to_where_the_noun_draws_them(name):
    """Every joint asked again at another place, angle, size and way: its points are where the first answer
    carries them.
    """
    assembly = page_model(getattr(gallery, name)()).assembly
    draw = np.random.default_rng(3)
    for joint in assembly.mechanism.joints.values():
        pins = [pin_of(assembly, end) for end in (joint.bearing, joint.journal)]
        ground = tuple(side[0] == "ground" for side in joint.sides)
        at = [place(assembly, pin) for pin in pins]
        angles = [float(assembly.state[assembly.layout.row("particle_theta", int(pin[0]))]) for pin in pins]
        asked = strokes.Inputs(at[0], at[1], tuple(angles), 1.3)
        found, _ = strokes.joint_strokes(joint, asked, tuple(angles), ground)
        moved = [
            tuple(np.array(one) + (0.0 if still else 1.0) * draw.uniform(-0.3, 0.3, 2))
            for one, still in zip(at, ground, strict=True)
        ]
        turned = [
            angle + (0.0 if still else draw.uniform(-2.0, 2.0))
            for angle, still in zip(angles, ground, strict=True)
        ]
        again = strokes.Inputs(moved[0], moved[1], tuple(turned), 1.31, (-0.4, 0.7))
        drawn = [
            strokes.points_of(stroke)
            for stroke in strokes.strokes_of(joint, again, tuple(angles), ground, [])
        ]
        for stroke, wanted in zip(found, [points for points in drawn if len(points)], strict=True):
            here = [placed(point, moved, turned, 1.31, (-0.4, 0.7)) for point in stroke["points"]]
            assert np.allclose(here, wanted, atol=1e-6)


def test_a_spring_is_drawn_between_its_pins():
    from vfife.model.drawing.strokes import zigzag
    from vfife.model.springs import Spring

    spring = Spring(name="s", first="a.b", second="c.d", stiffness=1.0)
    found = strokes.pair_strokes(spring, strokes.Inputs((0.0, 0.0), (1.0, 0.0), (0.0, 0.0), 2.0))
    ends = (0.3, 0.1), (0.9, 1.4)
    here = [placed(point, ends, (0.0, 0.0), 2.0, (0.0, 0.0)) for point in found[0]["points"]]
    assert np.allclose(here, zigzag(np.array(ends[0]), np.array(ends[1]), 0.018 * 2.0), atol=1e-9)


@pytest.mark.parametrize(("make", "kind"), CASES)
def test_every_kind_goes_into_a_page(make, kind):
    """Joints, springs, drivers and loads of all kinds: named, drawn where there is something to draw, and
    told in JSON.
    """
    told = json.loads(json.dumps(given(page_model(make(kind), 1e-5, force=True)), allow_nan=False))
    if make.__name__ in ("with_joint", "with_spring"):
        (noun,) = (one for one in [*told["joints"], *told["springs"]] if one["name"] in ("joint", "spring"))
        assert noun["strokes"] and all(
            len(point) == 10 for stroke in noun["strokes"] for point in stroke["points"]
        )
    if make.__name__ == "with_load":
        assert [load["name"] for load in told["loads"]] == ["load"] and any(told["loads"][0]["acts"])
