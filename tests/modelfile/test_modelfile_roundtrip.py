"""Model files: a mechanism comes back from its file, and no broken file raises anything but a ModelError."""

from __future__ import annotations

import contextlib
import copy
import json
import math
import time
import tomllib
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from model_texts import DEMO, FILES, FOUR_BAR, PLAYGROUND, TEMPLATES
from support import often
from vfife.errors import ModelError
from vfife.laws import Ambrosio, Frictionless, LankaraniNikravesh, Material, Pereira
from vfife.model import bodies, drivers, joints, loads, springs
from vfife.model.mechanism import Mechanism, Settings, StartSettings
from vfife.modelfile import dump, load
from vfife.modelfile import loads as read

# ---------------------------------------------------------------------------------------------------------
# round trips

number = st.floats(-1e6, 1e6, allow_nan=False)
positive = st.floats(1e-9, 1e9)
point = st.tuples(number, number)
name = st.text(min_size=1, max_size=8).filter(
    lambda s: s.isprintable() and s == s.strip() and "." not in s and s != "ground"
)
material = st.builds(
    lambda modulus, ratio: Material(f"m{modulus!r}{ratio!r}".replace(".", "_"), modulus, ratio, 1000.0),
    positive,
    st.floats(0.0, 0.5),
)
common: dict[str, Any] = {
    "angle": number,
    "position": st.none() | point,
    "velocity": st.just((0.0, 0.0, 0.0)),
    "material": st.just(Material()) | material,
}
section = st.builds(
    # The outermost fibre is no nearer than the radius of gyration.
    lambda area, bending, out: bodies.Section(
        area, bending, None if out is None else out * math.sqrt(bending / area)
    ),
    positive,
    positive,
    st.none() | st.floats(1.0, 10.0),
)
direction = st.tuples(st.floats(0.1, 10.0), number)
links = {
    "rigid": {
        "mass": positive,
        "inertia": st.none() | positive,
        "center_at": st.none() | number,
        "section": st.none() | section,
        "pins": st.dictionaries(
            name.filter(lambda s: s not in ("start", "end", "center")), point, max_size=2
        ),
    },
    "elastic": {"mass": st.none() | positive, "section": section, "elements": st.integers(1, 100)},
    "two-particle": {"mass": st.none() | positive, "section": section},
}


@st.composite
def a_frame(draw: st.DrawFn, called: str, values: dict[str, Any]) -> bodies.Frame:
    """Nodes one after the other, each joined to the one before, the last perhaps to the first."""
    names = draw(st.lists(name, min_size=2, max_size=4, unique=True))
    nodes = {one: (float(k), draw(st.floats(-10.0, 10.0))) for k, one in enumerate(names)}
    pairs = list(zip(names, names[1:], strict=False)) + (
        [(names[-1], names[0])] if len(names) > 2 and draw(st.booleans()) else []
    )
    common_section = draw(st.none() | section)
    members = tuple(
        bodies.Member(
            one,
            two,
            elements=draw(st.integers(1, 50)),
            section=draw(section if common_section is None else st.none() | section),
            material=draw(st.none() | material),
            mass=draw(st.none() | positive),
        )
        for one, two in pairs
    )
    masses = {one: draw(positive) for one in draw(st.lists(st.sampled_from(names), unique=True))}
    return bodies.Frame(
        name=called, nodes=nodes, members=members, section=common_section, masses=masses, **values
    )


@st.composite
def a_body(draw: st.DrawFn, called: str) -> bodies.Body:
    kind = draw(st.sampled_from(["rigid", "elastic", "two-particle", "plate", "particle", "frame"]))
    values: dict[str, Any] = {key: draw(strategy) for key, strategy in common.items()}
    if kind == "frame":
        return draw(a_frame(called, values))
    if kind == "particle":
        return bodies.PointMass(
            name=called, mass=draw(positive), inertia=draw(st.just(0.0) | positive), **values
        )
    if kind == "plate":
        points = draw(st.dictionaries(name.filter(lambda s: s != "center"), point, max_size=3))
        return bodies.RigidBody(
            name=called,
            mass=draw(positive),
            inertia=draw(positive),
            center=draw(point),
            pins=points,
            **values,
        )
    values |= {key: draw(strategy) for key, strategy in links[kind].items()}
    if kind != "rigid":
        values["release"] = draw(st.sampled_from(["none", "end"]))
        values["stiffness_factor"] = draw(positive)
    length = draw(positive)
    if kind != "two-particle" and draw(st.booleans()):
        values["via"] = tuple(
            (x * length, draw(st.floats(0.1, 9.0)) * length) for x in (0.25, 0.5)[: draw(st.integers(1, 2))]
        )
        values["elements"] = draw(st.integers(3, 100)) if kind == "elastic" else 4
    ends = ("start_mass", "end_mass", "start_inertia", "end_inertia")
    masses = {key: draw(st.just(0.0) | positive) for key in ends}
    return bodies.Link(name=called, length=length, model=kind, **values, **masses)  # type: ignore[arg-type]


@st.composite
def a_joint(draw: st.DrawFn, called: str, bearing: str, journal: str) -> joints.Joint:
    sides = {"name": called, "bearing": bearing, "journal": journal}
    kind = draw(st.sampled_from(["ideal", "ideal", "slider", "weld", "clearance", "block", "round", "line"]))
    if kind == "ideal":
        return joints.IdealRevolute(**sides)
    if kind == "weld":
        return joints.Weld(**sides)
    if kind == "slider":
        return joints.Slider(**sides, direction=draw(direction), turning=draw(st.booleans()))
    contact = st.builds(LankaraniNikravesh, restitution=st.floats(0.01, 1.0), stiffness=st.none() | positive)
    friction = st.just(Frictionless()) | st.builds(
        lambda f, v, more: Ambrosio(coefficient=f, v0=v, v1=v + more),
        st.floats(0, 1),
        st.floats(0, 1),
        st.floats(1e-3, 1),
    )
    values: dict[str, Any] = {
        **sides,
        "axial_length": draw(positive),
        "contact": draw(contact | st.builds(Pereira, restitution=st.floats(0.01, 1.0))),
        "friction": draw(friction),
        "friction_moment": draw(st.sampled_from(["mid-overlap", "surface", "off"])),
        "impact_speed_floor": draw(st.floats(1e-9, 1e8)),
        "landing_depth": draw(st.none() | positive),
        "bearing_material": draw(st.none() | material),
        "journal_material": draw(st.none() | material),
    }
    if kind == "block":
        sizes = {
            "length": draw(st.floats(0.1, 1.0)),
            "height": draw(st.floats(0.1, 1.0)),
            "corner_radius": draw(st.floats(1e-4, 0.05)),
        }
        return joints.ClearanceSlider(**values, clearance=draw(positive), direction=draw(direction), **sizes)
    if kind == "round":
        return joints.ExternalContact(**values, journal_radius=draw(positive), bearing_radius=draw(positive))
    if kind == "line":
        return joints.ExternalContact(**values, journal_radius=draw(positive), direction=draw(direction))
    return joints.ClearanceRevolute(
        **values, clearance=draw(st.floats(1e-5, 1e-3)), bearing_radius=draw(st.floats(2e-3, 1.0))
    )


@st.composite
def a_driver(
    draw: st.DrawFn, target: dict[str, Any], *, motion: bool = True, static: bool = False
) -> drivers.Driver:
    over = tuple(
        float(t) for t in sorted(draw(st.lists(st.integers(0, 1000), min_size=2, max_size=4, unique=True)))
    )
    values = tuple(draw(number) for _ in over)
    moving: list[drivers.Driver] = [
        drivers.StepTo(
            **target, travel=draw(number), duration=draw(positive), begin=draw(st.just(0.0) | number)
        ),
        drivers.Harmonic(
            **target, amplitude=draw(number), frequency=draw(positive), phase=draw(st.just(0.0) | number)
        ),
        drivers.AngleTable(**target, times=over, values=values),
    ]
    if not static:
        moving += [
            drivers.ConstantSpeed(**target, speed=draw(number)),
            drivers.Ramp(**target, speed=draw(number), duration=draw(positive)),
        ]
    pushing: list[drivers.Driver] = [
        drivers.Torque(**target, value=draw(number)),
        *(
            drivers.Torque(**target, value=values, **{axis: over})
            for axis in ("times", "angles", *([] if static else ["speeds"]))
        ),
    ]
    choice = (moving if motion else []) + ([] if "slider" in target else pushing)
    return draw(st.sampled_from(choice))


@st.composite
def a_spring(
    draw: st.DrawFn, called: str, pins: tuple[str, str], turned: tuple[str, str]
) -> springs.AnySpring:
    ends, around = (
        {"name": called, "first": pins[0], "second": pins[1]},
        {"name": called, "first": turned[0], "second": turned[1]},
    )
    low, room = draw(number), draw(st.floats(0.1, 10.0))
    axes = st.tuples(positive, st.just(0.0) | positive, st.just(0.0) | positive)
    return draw(
        st.sampled_from(
            [
                springs.Spring(
                    **ends,
                    stiffness=draw(positive),
                    damping=draw(st.just(0.0) | positive),
                    free_length=draw(st.none() | positive),
                ),
                springs.Spring(**ends, damping=draw(positive)),
                springs.TorsionalSpring(
                    **around, stiffness=draw(positive), free_angle=draw(st.none() | number)
                ),
                springs.Stop(
                    **around,
                    low=low,
                    high=low + room,
                    stiffness=draw(positive),
                    damping=draw(st.just(0.0) | positive),
                ),
                springs.Bushing(**ends, stiffness=draw(axes), damping=draw(axes)),
            ]
        )
    )


@st.composite
def mechanisms(draw: st.DrawFn) -> Mechanism:
    names = draw(st.lists(name, min_size=1, max_size=3, unique=True))
    model = Mechanism(
        draw(st.text(max_size=20).filter(str.isprintable)),
        draw(st.text(max_size=40).filter(str.isprintable)),
        draw(point),
    )
    model.points = draw(st.dictionaries(name, point, min_size=1, max_size=3))
    model.bodies = {body: draw(a_body(body)) for body in names}
    static = draw(st.booleans())
    base = before = f"ground.{next(iter(model.points))}"
    for k, body in enumerate(names):
        pins = list(model.bodies[body].points)
        model.joints[f"J{k}"] = draw(a_joint(f"J{k}", before, f"{body}.{pins[0]}"))
        before = f"{body}.{pins[-1]}"
    first = model.joints["J0"]
    if draw(st.booleans()):
        driven = {"body": names[0]}
        model.drivers[names[0]] = draw(
            a_driver(driven, motion=isinstance(first, joints.IdealRevolute), static=static)
        )
    elif isinstance(first, joints.Slider):
        model.drivers["D"] = draw(a_driver({"slider": "J0"}, static=static))
    elif "D" not in names:
        other = (
            {"body": names[-1], "against": names[0]}
            if len(names) > 2
            else {"point": before, "direction": draw(direction)}
        )
        model.drivers["D"] = draw(a_driver(other, static=static))
    if len(names) > 1:
        if draw(st.booleans()):
            model.gears["G"] = joints.Gear(name="G", first=names[0], second=names[1], ratio=-draw(positive))
        pair = draw(st.sampled_from([("ground", names[1]), (names[0], names[1])]))
        model.springs["S"] = draw(a_spring("S", (base, before), pair))
    turned = any(not isinstance(driver, drivers.Torque) and driver.body for driver in model.drivers.values())
    if draw(st.booleans()):
        table = {"times": (0.0, 1.0), "factors": draw(point)} if draw(st.booleans()) else {}
        force = loads.PointForce(
            name="F", at=before, force=draw(point), moment=draw(number), follow=draw(st.booleans()), **table
        )
        model.loads["F"] = force
    model.start = StartSettings(
        draw(st.sampled_from(["consistent", "rough"])), draw(st.sampled_from(["centred", "seated"]))
    )
    length = None if static else draw(st.none() | positive)
    equilibrium: dict[str, Any] = {
        "analysis": "static",
        "load_factors": tuple(draw(st.lists(number, min_size=1, max_size=3))),
        "residual": draw(st.floats(1e-12, 0.1)),
        "kinetic_energy": draw(st.floats(1e-12, 0.1)),
        "iterations": draw(st.integers(1, 10**9)),
    }
    model.settings = Settings(
        turns=length if turned else None,
        duration=None if turned else length,
        step=draw(st.just("auto") | positive),
        outputs=draw(st.integers(1, 10_000)),
        damping=draw(st.just(0.0) | positive),
        path_unit=draw(st.integers(1, 100)),
        **(equilibrium if static else {}),
    )
    return model


@settings(max_examples=often(150), deadline=None)
@given(mechanisms())
def test_what_is_dumped_loads_back_equal(model: Mechanism) -> None:
    text = dump(model)
    assert read(text) == model
    assert list(read(text).bodies) == list(model.bodies)
    assert dump(read(text)) == text


def test_two_materials_of_one_name_cannot_be_dumped() -> None:
    model = Mechanism()
    model.point_mass("a", mass=1.0, material=Material("x", 1e9))
    model.point_mass("b", mass=1.0, material=Material("x", 2e9))
    with pytest.raises(ValueError, match="two different materials are called 'x'"):
        dump(model)


def test_the_ideal_mechanism_can_be_dumped() -> None:
    """Its rigid links still have the number of elements that they had, which a rigid link has no use for."""
    model = load(
        DEMO,
        set=[
            ("body.coupler.model", "elastic"),
            ("body.coupler.elements", 8),
            ("body.coupler.release", "none"),
        ],
    )
    again = read(dump(model.ideal()))
    assert not again.clearances
    assert again.bodies["coupler"].model == "rigid"


# ------------------------------------------------------------------------------------------------------- fuzz

SOURCES = [
    FOUR_BAR,
    PLAYGROUND,
    PLAYGROUND,
    *(path.read_text(encoding="utf-8") for path in (*FILES, *TEMPLATES)),
]
LIMIT = 2.0  # seconds that anything wrong may take to be told
VALUES: list[Any] = [
    *(0, -1, 1, 10**30, 0.5, -0.0, 1e308, math.nan, math.inf, True),
    *("", "x", ".", "0.5 mm", "5 kg", "nan", "crank", "crank.end", "ground", "ground.A", "\x00\n\"'\\", "𝛿"),
    *(
        "slider",
        "weld",
        "contact",
        "clearance-slider",
        "frame",
        "stop",
        "bushing",
        "torsional",
        "static",
        "guide",
        "truss.C",
        "A",
    ),
    *(
        [{"start": "A", "end": "B"}],
        [{"start": "A", "elements": 10**6}],
        [0, 0],
        ["a", "b"],
        10**400,
        "1e999 m",
        "\u202e",
        "x" * 200,
    ),
    *("clearance", "ideal", "elastic", "two-particle", "particle", "rigid", "both", "pereira"),
    *([], [1], [1, 2], [1, "2 mm", 3], [[]], [[1, 2], [3]], ["a.b"] * 9),
    *({}, {"a": 1}, {"law": "none"}, {"law": []}, {"start": [0, 0]}),
]
KEYS = [
    *(
        "x",
        "",
        "a.b",
        "𝛿",
        "run",
        "turns",
        "ground",
        "body",
        "model",
        "length",
        "mass",
        "section",
        "pins",
        "material",
    ),
    *(
        "gear",
        "spring",
        "nodes",
        "members",
        "masses",
        "via",
        "tube",
        "direction",
        "turning",
        "first",
        "second",
        "ratio",
        "stiffness",
    ),
    *(
        "slider",
        "point",
        "against",
        "travel",
        "amplitude",
        "travels",
        "speeds",
        "force",
        "follow",
        "analysis",
        "load_factors",
        "\n",
    ),
    *(
        "release",
        "joint",
        "kind",
        "bearing",
        "clearance",
        "contact",
        "law",
        "driver",
        "speed",
        "torque",
        "times",
    ),
]


def toml(value: Any) -> str:
    """A value as TOML, tables in line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml(str(key))} = {toml(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str | bool) else str(value)


def tables(value: Any) -> Iterator[Any]:
    """All tables and lists in a value, itself first."""
    if isinstance(value, dict | list):
        yield value
        for entry in value.values() if isinstance(value, dict) else value:
            yield from tables(entry)


def told(text: str) -> None:
    """A broken text is refused in words and soon, or it is none and means what it says."""
    began = time.process_time()
    try:
        model = read(text)
    except ModelError as error:
        assert error.faults
        assert all(str(fault).isprintable() and "Error" not in str(fault) for fault in error.faults), str(
            error
        )
    else:
        assert read(dump(model)) == model
    assert time.process_time() - began < LIMIT


def broken(data: st.DataObject) -> dict[str, Any]:
    """Tables of a model with some entries deleted, replaced, added, exchanged or renamed."""
    raw = copy.deepcopy(tomllib.loads(data.draw(st.sampled_from(SOURCES))))
    for _ in range(data.draw(st.integers(1, 4))):
        holder = data.draw(st.sampled_from(list(tables(raw))))
        keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
        key = data.draw(st.sampled_from([*keys, *(KEYS if isinstance(holder, dict) else [])] or ["x"]))
        what = data.draw(st.sampled_from(["delete", "exchange", "rename", "set"]))
        if key in keys and what == "delete":
            del holder[key]
        elif key in keys and what == "exchange":
            other = data.draw(st.sampled_from(keys))
            holder[key], holder[other] = holder[other], holder[key]
        elif isinstance(holder, dict) and key in keys and what == "rename":
            holder[data.draw(st.sampled_from(KEYS) | st.text(max_size=5))] = holder.pop(key)
        elif isinstance(holder, dict):
            holder[key] = copy.deepcopy(data.draw(st.sampled_from(VALUES)))
        else:
            holder.append(copy.deepcopy(data.draw(st.sampled_from(VALUES))))
    return raw


@settings(max_examples=often(600), deadline=None)
@given(st.data())
def test_broken_tables_raise_nothing_but_model_errors(data: st.DataObject) -> None:
    told("\n".join(f"{toml(key)} = {toml(value)}" for key, value in broken(data).items()))


@settings(max_examples=often(200), deadline=None)
@given(
    st.sampled_from([FOUR_BAR, PLAYGROUND]),
    st.integers(0, len(PLAYGROUND)),
    st.text(max_size=5),
    st.integers(0, 20),
)
def test_broken_texts_raise_nothing_but_model_errors(whole: str, at: int, more: str, less: int) -> None:
    told(whole[:at] + more + whole[at + less :])


@settings(max_examples=often(200), deadline=None)
@given(
    st.lists(
        st.sampled_from([*KEYS, "C", "crank", "A", "0", "C-D", "crank-coupler", "steel"]),
        min_size=1,
        max_size=5,
    ),
    st.sampled_from(VALUES),
)
def test_broken_paths_raise_nothing_but_model_errors(path: list[str], value: Any) -> None:
    with contextlib.suppress(ModelError):
        read(FOUR_BAR, [(".".join(path), value), ("joint.C.kind", "ideal"), ("material.steel.density", 1)])


@settings(max_examples=often(100), deadline=None)
@given(st.text(max_size=30), st.text(max_size=30))
def test_any_text_can_be_set(path: str, value: str) -> None:
    for where in (path, f"joint.{path}", "joint.C.clearance", "name"):
        with contextlib.suppress(ModelError):
            read(FOUR_BAR, [(where, value)])
