"""Builders take what a model file takes, and say the same of it: nouns and sentences of both are compared,
key by key.
"""

from __future__ import annotations

import math
import sys
from typing import Any

import numpy as np
import pytest

import vfife
from vfife.modelfile import dump, loads
from vfife.simulation.simulate import RunArguments, prepare

HEAD = 'name = "machine"\n'
# What a builder is given; the same as a table of a model file.
SAME: list[tuple[str, dict[str, Any], str]] = [
    (
        "link",
        {
            "length": "100 mm",
            "mass": "200 g",
            "section": {"round": "20 mm"},
            "model": "elastic",
            "angle": "30 deg",
            "material": "aluminium",
        },
        (
            'length = "100 mm"\nmass = "200 g"\nsection = { round = "20 mm" }\nmodel = "elastic"\nangle = "30'
            ' deg"\nmaterial = "aluminium"'
        ),
    ),
    (
        "rigid_body",
        {"mass": "2 kg", "inertia": "12 kg mm^2", "pins": {"eye": ("10 mm", 0)}, "masses": {"eye": "5 g"}},
        'mass = "2 kg"\ninertia = "12 kg mm^2"\npins = { eye = ["10 mm", 0] }\nmasses = { eye = "5 g" }',
    ),
    (
        "frame",
        {
            "nodes": {"A": (0, 0), "B": ("1 m", 0)},
            "members": [{"start": "A", "end": "B", "elements": 3}],
            "section": {"tube": ("20 mm", "16 mm")},
        },
        (
            'model = "frame"\nnodes = { A = [0, 0], B = ["1 m", 0] }\nmembers = [{ start = "A", end = "B",'
            ' elements = 3 }]\nsection = { tube = ["20 mm", "16 mm"] }'
        ),
    ),
]


@pytest.mark.parametrize(("builder", "given", "table"), SAME, ids=[one[0] for one in SAME])
def test_a_builder_makes_what_a_model_file_makes(builder: str, given: dict[str, Any], table: str) -> None:
    m = vfife.Mechanism("machine")
    getattr(m, builder)("part", **given)
    assert m.bodies == loads(f"{HEAD}[body.part]\n{table}\n").bodies


def test_joints_and_springs_take_texts_laws_and_materials_by_name() -> None:
    m = pendulum()
    m.point("P", "300 mm", "-400 mm")
    m.drive("arm", speed="1500 rpm")
    m.torsional_spring("coil", "ground", "arm", stiffness="20 N m/rad", free_angle="-90 deg")
    m.clearance_joint(
        "C", "arm.end", "weight.center", clearance="0.2 mm", bearing_radius="10 mm",
        contact={"law": "flores", "restitution": 0.8},
        friction="none", bearing_material="bronze",
    )  # fmt: skip
    assert m.points["P"] == (0.3, -0.4)
    assert m.drivers["arm"].largest_speed == pytest.approx(50.0 * math.pi, rel=1e-15)
    joint = m.contacts["C"]
    assert (joint.contact.name, joint.friction.name, joint.bearing_material) == (
        "flores",
        "none",
        vfife.laws.MATERIALS["bronze"],
    )
    back = loads(m.to_toml())
    assert (back.joints, back.springs, back.drivers, back.points) == (
        m.joints,
        m.springs,
        m.drivers,
        m.points,
    )


def test_numbers_of_numpy_are_numbers() -> None:
    m = vfife.Mechanism("m")
    m.point("O", np.float32(0.5), np.int64(2))
    m.link("rod", length=np.float64(1.0), mass=np.float32(0.25), via=np.array([[0.5, 0.1]]))
    assert m.points == {"O": (0.5, 2.0)}
    assert m.bodies["rod"].via == ((0.5, 0.1),)
    assert all(type(value) is float for value in (*m.points["O"], m.bodies["rod"].mass))


# What is wrong, in a builder and in a model file: the keyword and what it is given.
WRONG: list[tuple[str, dict[str, Any], str]] = [
    ("link", {"length": "2 kg", "mass": 1}, 'length = "2 kg"\nmass = 1'),
    ("link", {"length": -1, "mass": 1}, "length = -1\nmass = 1"),
    ("link", {"length": "1,5 m", "mass": 1}, 'length = "1,5 m"\nmass = 1'),
    ("link", {"length": 1, "mass": 1, "model": "elstic"}, 'length = 1\nmass = 1\nmodel = "elstic"'),
    ("link", {"length": 1}, "length = 1"),
    ("link", {"length": 1, "mass": True}, "length = 1\nmass = true"),
    ("link", {"length": 1, "section": {"tube": (1, 2)}}, "length = 1\nsection = { tube = [1, 2] }"),
    (
        "link",
        {"length": 1, "section": {"round": 1, "square": 1}},
        "length = 1\nsection = { round = 1, square = 1 }",
    ),
    ("link", {"length": 1, "mass": 1, "model": "elastic"}, 'length = 1\nmass = 1\nmodel = "elastic"'),
    (
        "link",
        {"length": 1, "mass": 1, "model": "rigid", "elements": 7},
        'length = 1\nmass = 1\nmodel = "rigid"\nelements = 7',
    ),
    (
        "rigid_body",
        {"mass": 1, "inertia": 1, "pins": {"center": (0.5, 0.5)}},
        "mass = 1\ninertia = 1\npins = { center = [0.5, 0.5] }",
    ),
    (
        "rigid_body",
        {"mass": 1, "inertia": 1, "masses": {"eye": 0.5}},
        "mass = 1\ninertia = 1\nmasses = { eye = 0.5 }",
    ),
    ("rigid_body", {"mass": 1, "inertia": 1, "center": (1,)}, "mass = 1\ninertia = 1\ncenter = [1]"),
]


@pytest.mark.parametrize(("builder", "given", "table"), WRONG)
def test_a_builder_says_what_a_model_file_says(builder: str, given: dict[str, Any], table: str) -> None:
    with pytest.raises(vfife.errors.ModelError) as of_file:
        loads(f"{HEAD}[body.part]\n{table}\n")
    m = vfife.Mechanism("machine")
    with pytest.raises(vfife.errors.ModelError) as of_python:
        getattr(m, builder)("part", **given)
    wanted = [fault for fault in of_file.value.faults if fault.where.startswith("[body.part")]
    assert [str(one) for one in of_python.value.faults] == [str(one) for one in wanted] != []
    assert not m.bodies, "what is refused is not there"


def pendulum() -> vfife.Mechanism:
    """An arm on a pivot, and a weight."""
    m = vfife.Mechanism("pendulum", gravity=(0, "-9.81 m/s^2"))
    m.point("O", 0, 0)
    m.link("arm", length="0.5 m", mass=1)
    m.point_mass("weight", mass="100 g")
    m.revolute("pivot", "ground.O", "arm.start")
    return m


def test_settings_take_texts_too() -> None:
    assert vfife.Settings(duration="20 ms", step="1 us").step == 1e-6
    assert vfife.Settings(step="auto").step == "auto"
    assert pendulum().gravity == (0.0, -9.81)


def test_a_model_file_is_loaded_with_overrides(tmp_path: Any) -> None:
    path = tmp_path / "model.toml"
    path.write_text(dump(vfife.gallery.four_bar()), encoding="utf-8")
    m = vfife.load(path, {"joint.C.clearance": "0.5 mm", "run.turns": 3, "body.crank.mass": np.float64(4.0)})
    assert (m.clearances["C"].clearance, m.settings.turns, m.bodies["crank"].mass) == (0.5e-3, 3.0, 4.0)
    assert vfife.load(str(path)).joints == vfife.load_model(path).joints == vfife.gallery.four_bar().joints


def test_a_mechanism_is_checked_drawn_and_shown() -> None:
    m = vfife.gallery.four_bar()
    found = m.check()
    assert (found.bodies, found.joints, found.free, found.after_drives) == (3, 4, 1, 0)
    assert "four-bar" in str(found) and "1; 0 when driven" in str(found)
    names = {text.get_text() for text in m.plot().axes[0].texts}
    assert {"B", "C", "D"} <= names
    m.name = "<b>&"
    page = m._repr_html_()
    assert (
        "data:image/svg+xml;base64," in page
        and "<b>&" not in page.replace("<b>Bodies", "")
        and "&lt;b&gt;&amp;" in page
    )
    assert all(f">{name}<" in page for name in (*m.bodies, *m.joints))


def test_the_step_that_check_tells_is_that_with_which_a_run_begins() -> None:
    m = vfife.gallery.four_bar()
    begun = prepare(m, RunArguments()).assembly.choice
    assert (m.check().step, m.check().set_by) == (begun.step, begun.culprit)


def test_a_mechanism_with_faults_is_shown_with_them() -> None:
    m = pendulum()
    m.revolute("lost", "crank.end", "arm.end")
    page = m._repr_html_()
    assert "there is no body &#x27;crank&#x27;" in page and "img" not in page
    with pytest.raises(vfife.errors.ModelError, match="there is no body 'crank'"):
        m.check()


def test_what_a_mechanism_asks_of_other_rooms_is_loaded_when_it_asks() -> None:
    import subprocess

    code = (
        "import sys, vfife; m = vfife.Mechanism('m'); m.point('O', 0, '1 m'); m.link('a', length='1 m',"
        " mass=1)\n"
    )
    code += (
        "print(sorted({'numba', 'llvmlite', 'matplotlib', 'scipy', 'xarray', 'pandas', 'pint'} &"
        " set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"
