"""What the machinery of every joint, spring and driver keeps: the same bits in all loops, mirror symmetry,
momenta, a second-order ledger.
"""

import dataclasses
from functools import cache

import numpy as np
import pytest

from support import bits, finer, lanes, mirrored, order, with_settings
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.compiler.runtime.loops import python_line
from vfife.kernels.blocks import BLOCKS
from vfife.laws import Ambrosio, HuntCrossley, LankaraniNikravesh, Material
from vfife.measures import ledger
from vfife.measures.motion import velocities
from vfife.model.bodies import Member, Section
from vfife.model.drivers import AngleTable, ConstantSpeed, Harmonic, StepTo, Torque
from vfife.model.joints import Distance, ExternalContact
from vfife.model.loads import PointForce
from vfife.model.mechanism import Mechanism
from vfife.model.springs import Stop, TorsionalSpring
from vfife.solvers.transient import run
from vfife_validation.verification.lagrange import solved
from vfife_validation.verification.pendulums import double_four_bar

RUBBER = Material("rubber", 2e8, 0.3, 1000.0)
STIFF = Material(
    "stiff", 2e9, 0.3, 1000.0
)  # its strains are small enough for the incremental law to be as good as conservative


def guides(lane: int = 0) -> Mechanism:
    """Sliders, slots, welds, gears and drivers of every kind, a guide with clearance, elastic bodies that
    carry guides.
    """
    f = 1.0 + 0.05 * lane
    m = Mechanism("guides", gravity=(0.4, -9.81 * f))
    for k, at in enumerate(((0.0, 0.0), (1.0, 0.2), (2.0, 0.1), (3.0, 0.0), (4.0, 0.3))):
        m.point(f"O{k}", *at)
    # A turning arm with a block along it, whose travel is prescribed, and one with clearance.
    m.rigid_body("arm", mass=1.0, inertia=0.1, pins={"far": (0.3, 0.02)}, angle=0.2)
    m.revolute("O0", "ground.O0", "arm.center")
    m.rigid_body("block", mass=0.4, inertia=2e-3, pins={"pin": (0.01, 0.03)}, position=(0.2, 0.05), angle=0.5)
    m.slider("along", "arm.far", "block.center", direction=(1.0, 0.2))
    m.drivers["push"] = Harmonic(slider="along", amplitude=0.03 * f, frequency=9.0)
    m.drivers["arm"] = StepTo(body="arm", travel=0.8, duration=0.03)
    m.rigid_body("loose", mass=0.3, inertia=1e-3, position=(0.3, 0.1), angle=0.2)
    options = {
        "contact": LankaraniNikravesh(restitution=0.7, stiffness=1e8),
        "friction": Ambrosio(coefficient=0.2, v0=1e-3, v1=1e-2),
        "corner_radius": 2e-3,
    }
    m.clearance_slider("play", "arm.far", "loose.center", clearance=3e-4, length=0.05, height=0.03, **options)
    # Geared wheels, the second with a pin in a slot of a swinging arm.
    m.rigid_body(
        "wheel",
        mass=1.0,
        inertia=0.02,
        position=(1.0, 0.2),
        pins={"eye": (0.02, 0.0)},
        velocity=(0.0, 0.0, 9.0 * f),
    )
    m.rigid_body("pinion", mass=0.5, inertia=0.004, position=(2.0, 0.1), pins={"pin": (0.05, 0.01)})
    m.rigid_body("swing", mass=0.8, inertia=0.02, position=(3.0, 0.0), pins={"end": (-0.2, 0.1)}, angle=0.1)
    m.revolute("O1", "ground.O1", "wheel.center")
    m.revolute("O2", "ground.O2", "pinion.center")
    m.revolute("O3", "ground.O3", "swing.center")
    m.gear("mesh", "wheel", "pinion", ratio=-2.5)
    m.rigid_body("planet", mass=0.1, inertia=2e-4)
    m.revolute("planet", "wheel.eye", "planet.center")
    m.gear("roll", "ground", "planet", ratio=-1.5)
    m.slider("slot", "swing.center", "pinion.pin", direction=(1.0, -0.1), turning=True)
    m.rigid_body("bob", mass=0.2, inertia=1e-3, pins={"eye": (0.03, 0.01)})
    m.distance("tie", "pinion.pin", "bob.eye", length=0.12, angle=-1.2)
    # A clamped elastic beam, a rigid arm welded to it, a link driven against that, a particle on a line, a
    # frame with a bead in a guide it carries.
    m.link(
        "beam",
        length=0.4,
        model="elastic",
        elements=2,
        section=Section.round(0.02),
        material=RUBBER,
        position=(4.0, 0.3),
    )
    m.weld("clamp", "ground.O4", "beam.start")
    m.rigid_body(
        "stub", mass=0.2, inertia=1e-3, pins={"root": (-0.05, 0.0), "tip": (0.05, 0.01)}, position=(4.45, 0.3)
    )
    m.weld("weld", "beam.end", "stub.root")
    m.link("finger", length=0.1, mass=0.05, position=(4.5, 0.31), angle=-0.4)
    m.revolute("knuckle", "stub.tip", "finger.start")
    m.drivers["motor"] = AngleTable(
        body="finger", against="stub", times=(0.0, 0.02, 0.05), values=(0.0, 0.3 * f, -0.2)
    )
    m.point_mass("bead", mass=0.1, position=(5.0, 1.0), velocity=(0.0, 0.3, 0.0))
    m.drivers["line"] = ConstantSpeed(point="bead.center", direction=(1.0, 0.5), speed=0.7 * f)
    nodes = {"a": (0.0, 0.0), "b": (0.2, 0.0), "c": (0.2, 0.2)}
    members = (Member("a", "b"), Member("b", "c"))
    m.frame(
        "frame",
        nodes=nodes,
        members=members,
        section=Section.round(0.02),
        material=RUBBER,
        position=(6.0, 0.0),
        velocity=(0.1, 0.2, 3.0),
    )
    m.rigid_body("rider", mass=0.1, inertia=1e-4, position=(6.2, 0.15), angle=0.3)
    m.slider("rail", "frame.c", "rider.center", direction=(0.1, 1.0))
    return with_settings(m, damping=0.5)


def springs(lane: int = 0) -> Mechanism:
    """Springs, dampers, bushings and stops, following forces, torques over time, speed and angle, rounds on a
    line and on each other.
    """
    f = 1.0 + 0.05 * lane
    m = Mechanism("springs", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.point("P", 1.0, 0.1)
    m.point("W", 2.0, -0.1)
    m.link("rod", length=0.3, mass=1.0 * f, angle=-0.3)
    m.revolute("O", "ground.O", "rod.start")
    m.rigid_body(
        "disc",
        mass=0.7,
        inertia=0.01,
        position=(0.7, 0.2),
        pins={"rim": (0.06, 0.02)},
        velocity=(0.3, 0.5, 20.0 * f),
    )
    m.spring("s", "rod.end", "disc.rim", stiffness=900.0, damping=4.0, free_length=0.3)
    m.torsional_spring("t", "ground", "rod", stiffness=5.0, damping=0.02, free_angle=0.2)
    m.bushing("b", "disc.rim", "ground.P", stiffness=(500.0, 900.0, 3.0), damping=(2.0, 1.0, 0.01))
    m.stop("st", "rod", "disc", low=-0.2, high=0.33, stiffness=80.0, damping=0.05)
    m.drivers["rod"] = Torque(body="rod", value=(3.0 * f, 0.0, -1.0), speeds=(-5.0, 0.0, 30.0))
    m.drivers["twist"] = Torque(body="disc", against="rod", value=(0.4, -0.6, 0.1), angles=(-1.0, 0.5, 2.0))
    m.loads["follow"] = PointForce(name="follow", at="disc.rim", force=(3.0, 1.0), moment=0.1, follow=True)
    m.loads["fixed"] = PointForce(
        name="fixed", at="rod.end", force=(1.0, 2.0), times=(0.0, 0.02, 0.04), factors=(0.0, 1.0, -0.5)
    )
    law, rough = HuntCrossley(restitution=0.6, stiffness=1e8), Ambrosio(coefficient=0.3, v0=1e-3, v1=1e-2)
    m.rigid_body("ball", mass=0.5, inertia=2e-4, position=(1.9, -0.0497), velocity=(1.0 * f, -0.4, -5.0))
    m.rigid_body("other", mass=0.3, inertia=1e-4, position=(2.01, -0.05), velocity=(-1.0, 0.0, 9.0))
    for name in ("ball", "other"):
        m.external_contact(
            f"floor {name}", "ground.W", f"{name}.center", journal_radius=0.05, contact=law, friction=rough
        )
    m.external_contact(
        "meet",
        "ball.center",
        "other.center",
        journal_radius=0.05,
        bearing_radius=0.05,
        contact=law,
        friction=rough,
    )
    return m


MODELS = {guides: 4e-6, springs: 4e-6}


@cache
def assembled(model, lane: int = 0) -> Assembly:
    """A lane of a model, with a step of its own."""
    return assemble(
        model(lane), MODELS[model] * (1 - 0.05 * lane), duration=0.03, outputs=60, force_step=True
    )


@cache
def computed(model, loop: str, width: int) -> tuple[np.ndarray, tuple[str, ...]]:
    assemblies = [assembled(model, lane) for lane in range(width)]
    runner = lanes(assemblies, loop)
    rows = np.concatenate([runner.advance(1, 1), runner.advance(50, 6 if loop == "interpreted" else 100)])
    layout = assemblies[0].layout
    names = {row: block.name for block in BLOCKS for row in layout[block.name].tolist()}
    return rows, tuple(names.get(int(row), "wide") for row in runner.row_numbers)


def differing(ours: np.ndarray, theirs: np.ndarray, names: tuple[str, ...]) -> set[str]:
    return {names[k] for k in np.flatnonzero((bits(ours) != bits(theirs)).any(axis=(0, 2)))}


@pytest.mark.system("steps in the interpreter")
@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_interpreted_is_data_driven(model):
    rows, names = computed(model, "data-driven", 4)
    plain, _ = computed(model, "interpreted", 1)
    assert np.isfinite(rows).all()
    assert differing(plain, rows[: len(plain), :, :1], names) == set()


@pytest.mark.system("steps in the interpreter")
@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_the_generated_text_is_data_driven(model):
    rows, names = computed(model, "data-driven", 4)
    runner = lanes([assembled(model)], "interpreted")
    runner.take = python_line(runner.topology)(runner.memory)
    with np.errstate(
        invalid="ignore"
    ):  # both sides of a choice are computed, also the one that means nothing
        plain = np.concatenate([runner.advance(1, 1), runner.advance(50, 6)])
    assert differing(plain, rows[: len(plain), :, :1], names) == set()


@pytest.mark.slow("compiles every kind of joint")
@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_four_lanes_are_data_driven_each(model):
    rows, names = computed(model, "data-driven", 4)
    four, _ = computed(model, "generated", 4)
    assert differing(four, rows, names) == set()


def test_the_runs_are_worth_comparing():
    rows, names = computed(guides, "data-driven", 4)
    at = {name: [k for k, other in enumerate(names) if other == name] for name in set(names)}
    assert (rows[-1, at["contact_onsets"]] > 0).any()
    assert (
        np.abs(rows[-1, at["joint_fx"]]).max(axis=1).min() >= 0.0
        and np.abs(rows[-1, at["joint_moment"]]).max() > 0.0
    )
    rows, names = computed(springs, "data-driven", 4)
    at = {name: [k for k, other in enumerate(names) if other == name] for name in set(names)}
    assert (rows[-1, at["contact_onsets"]] > 0).any(axis=1).sum() >= 2
    assert (np.abs(rows[:, at["spring_fx"]]).max(axis=(0, 2)) > 0).sum() == 2 and (
        np.abs(rows[:, at["spring_moment"]]).max(axis=(0, 2)) > 0
    ).sum() == 3


# ------------------------------------------------------------------------------------------------------------
# mirror image


def reflected(m: Mechanism) -> Mechanism:
    """The mirror image at the x axis, of every kind of joint, spring and driver."""

    def driver(d):
        if isinstance(d, Torque) and (d.speeds or d.angles):
            turned = {
                key: tuple(-v for v in reversed(getattr(d, key)))
                for key in ("value", "speeds", "angles")
                if getattr(d, key)
            }
            return dataclasses.replace(d, **turned)
        along = bool(d.slider or d.point)
        d = dataclasses.replace(d, direction=(d.direction[0], -d.direction[1]))
        if along:
            return d
        name = {"Harmonic": "amplitude", "StepTo": "travel", "AngleTable": "values", "Torque": "value"}.get(
            type(d).__name__, "speed"
        )
        value = getattr(d, name)
        return dataclasses.replace(
            d, **{name: tuple(-v for v in value) if isinstance(value, tuple) else -value}
        )

    def joint(j):
        if isinstance(j, ExternalContact):
            return dataclasses.replace(j, direction=(-j.direction[0], j.direction[1]))
        if isinstance(j, Distance):
            return dataclasses.replace(j, angle=-j.angle)
        return (
            dataclasses.replace(j, direction=(j.direction[0], -j.direction[1]))
            if hasattr(j, "direction")
            else j
        )

    def spring(s):
        if isinstance(s, TorsionalSpring):
            return dataclasses.replace(s, free_angle=None if s.free_angle is None else -s.free_angle)
        return dataclasses.replace(s, low=-s.high, high=-s.low) if isinstance(s, Stop) else s

    def body(b):
        return (
            dataclasses.replace(b, nodes={k: (x, -y) for k, (x, y) in b.nodes.items()})
            if hasattr(b, "nodes")
            else b
        )

    plain = mirrored(dataclasses.replace(m, drivers={}))
    return dataclasses.replace(
        plain,
        bodies={name: body(b) for name, b in plain.bodies.items()},
        joints={name: joint(j) for name, j in m.joints.items()},
        springs={name: spring(s) for name, s in m.springs.items()},
        drivers={name: driver(d) for name, d in m.drivers.items()},
    )


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_the_mirror_image_moves_as_the_mirror_image(model):
    """Rounding alone tells them apart: tables of functions and corners of blocks are not summed in the same
    order.
    """
    image = assemble(reflected(model()), MODELS[model], duration=0.03, outputs=60, force_step=True)
    ours, theirs = (run(a, loop="data-driven") for a in (assembled(model), image))
    checks = {
        "particle_x": (1.0, 1e-9),
        "particle_y": (-1.0, 1e-9),
        "particle_theta": (-1.0, 1e-9),
        "body_alpha": (-1.0, 1e-6),
    }
    for block, (sign, tolerance) in checks.items():
        a, b = ours.block(block), sign * theirs.block(block)
        assert np.abs(a - b).max() < tolerance * max(1.0, np.abs(a).max()), block
    assert ours.block("contact_onsets")[-1].sum() == theirs.block("contact_onsets")[-1].sum() > 0


# ------------------------------------------------------------------------------------------------ what floats


def floating(**change) -> Mechanism:
    """Bodies in space that springs, a bushing, a slider, a slot, a weld, a motor and a stop hold together,
    and an elastic link.
    """
    m = Mechanism("floating")
    m.rigid_body(
        "a",
        mass=1.0,
        inertia=0.02,
        pins={"p": (0.1, 0.05), "q": (-0.1, 0.0)},
        position=(0.0, 0.0),
        velocity=(0.3, 0.1, 6.0),
    )
    m.rigid_body(
        "b",
        mass=0.6,
        inertia=0.01,
        pins={"p": (0.05, 0.0)},
        position=(0.3, 0.1),
        angle=0.2,
        velocity=(0.0, -0.2, -3.0),
    )
    m.rigid_body("c", mass=0.5, inertia=0.01, pins={"p": (-0.1, 0.0)}, position=(0.2, 0.05))
    m.slider("rail", "a.p", "b.p", direction=(1.0, 0.3))
    m.revolute("pin", "a.q", "c.p")
    m.link(
        "beam",
        length=0.3,
        model="elastic",
        elements=3,
        section=Section.round(0.02),
        material=STIFF,
        position=(0.35, 0.1),
        angle=0.2,
    )
    m.weld("weld", "b.p", "beam.start")
    m.point_mass("bead", mass=0.2, position=(-0.3, 0.1))
    m.slider("slot", "c.center", "bead.center", direction=(0.2, 1.0), turning=True)
    m.spring("s", "beam.end", "bead.center", stiffness=200.0, damping=1.5, free_length=0.5)
    m.rigid_body("d", mass=0.4, inertia=0.005, position=(0.0, 0.0), velocity=(0.2, 0.0, 0.0))
    m.bushing("bush", "a.center", "d.center", stiffness=(3e3, 5e3, 20.0), damping=(4.0, 2.0, 0.05))
    m.torsional_spring("t", "c", "d", stiffness=3.0, damping=0.01)
    m.stop("stop", "a", "d", low=-0.02, high=0.02, stiffness=30.0, damping=0.02)
    m.drivers["motor"] = Torque(body="d", against="a", value=(0.5, -0.2), times=(0.0, 0.1))
    return dataclasses.replace(m, **change)


def momenta(record) -> tuple[np.ndarray, np.ndarray]:
    """Momentum (outputs, 2) and angular momentum about the origin (outputs,)."""
    im, ii = record.parameter("particle_inverse_mass"), record.parameter("particle_inverse_inertia")
    mass = np.divide(1.0, im, out=np.zeros_like(im), where=im > 0)
    inertia = np.divide(1.0, ii, out=np.zeros_like(ii), where=ii > 0)
    v = velocities(record)
    x, y = record.block("particle_x"), record.block("particle_y")
    spin = (mass * (x * v["v"] - y * v["u"]) + inertia * v["w"]).sum(axis=1)
    return np.stack([(mass * v["u"]).sum(axis=1), (mass * v["v"]).sum(axis=1)], axis=1), spin


def test_momenta_of_what_floats():
    """Forces within it come in pairs, and moments too: both momenta are kept to rounding at any step."""
    for step in (2e-5, 1e-5):
        record = run(
            assemble(floating(), step, duration=0.1, outputs=100, force_step=True), loop="data-driven"
        )
        push, spin = momenta(record)
        assert np.abs(push - push[0]).max() < 1e-11 * np.abs(push[0]).max()
        assert np.abs(spin - spin[0]).max() < 1e-11 * np.abs(spin[0]).max()
        assert (
            np.abs(record.block("particle_w")).max() > 1.0 and np.abs(record.block("spring_fx")[-1, 0]) > 1.0
        )
        assert (np.abs(record.block("spring_moment")[:, -1]) > 0.0).any(), "the stop is never met"


def test_ledger_of_what_floats_is_of_second_order():
    m = floating()
    del m.springs["stop"]  # it begins and ends within steps, which costs the order
    start = assemble(m, 2e-5, duration=0.05, outputs=50, force_step=True)
    errors = [ledger(run(finer(start, times), loop="data-driven")).error for times in (1, 2, 4)]
    assert errors[-1] < 1e-5
    assert min(order(errors)) > 1.8, errors


def single(kind: str) -> Mechanism:
    """One element or joint of a kind in a mechanism of its own."""
    m = Mechanism(kind, gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.rigid_body("a", mass=1.0, inertia=0.05, pins={"p": (0.3, 0.1)}, angle=0.3, velocity=(0.0, 0.0, 4.0))
    m.revolute("O", "ground.O", "a.center")
    m.rigid_body(
        "b", mass=0.5, inertia=0.02, pins={"q": (0.05, 0.0)}, position=(0.3, 0.2), velocity=(0.5, 0.2, -2.0)
    )
    if kind in ("slider", "slot"):
        m.slider("j", "a.p", "b.center", direction=(1.0, 0.5), turning=kind == "slot")
    elif kind == "weld":
        m.weld("j", "a.p", "b.q")
    elif kind == "gear":
        m.gear("g", "a", "b", ratio=1.5)
    elif kind == "spring":
        m.spring("s", "a.p", "b.q", stiffness=300.0, damping=3.0, free_length=0.1)
    elif kind == "torsional":
        m.torsional_spring("s", "a", "b", stiffness=6.0, damping=0.05, free_angle=0.4)
    elif kind == "bushing":
        m.bushing("s", "a.p", "b.q", stiffness=(400.0, 900.0, 5.0), damping=(3.0, 5.0, 0.02))
    elif kind == "relative":
        m.drivers["d"] = Harmonic(body="b", against="a", amplitude=0.4, frequency=3.0)
    elif kind == "travel":
        m.slider("j", "a.p", "b.center", direction=(1.0, 0.5))
        m.drivers["d"] = Harmonic(slider="j", amplitude=0.1, frequency=4.0)
    elif kind == "point":
        m.drivers["d"] = Harmonic(point="b.q", direction=(1.0, 2.0), amplitude=0.1, frequency=4.0)
    elif kind == "speed":
        m.drivers["d"] = Torque(body="a", value=(2.0, 0.0), speeds=(0.0, 20.0))
    elif kind == "angle":
        m.drivers["d"] = Torque(body="a", value=(2.0, -1.0, 3.0), angles=(0.0, 1.0, 2.0))
    elif kind == "follow":
        m.loads["f"] = PointForce(name="f", at="b.q", force=(2.0, -1.0), moment=0.1, follow=True)
    return m


KINDS = (
    "slider",
    "slot",
    "weld",
    "gear",
    "spring",
    "torsional",
    "bushing",
    "relative",
    "travel",
    "point",
    "speed",
    "angle",
    "follow",
)


@pytest.mark.parametrize("kind", KINDS)
def test_ledger_of_each_kind_is_of_second_order(kind):
    start = assemble(single(kind), 4e-4, duration=0.4, outputs=40, force_step=True)
    errors = [ledger(run(finer(start, times), loop="data-driven")).error for times in (1, 2, 4)]
    assert errors[-1] < 1e-4, errors
    assert min(order(errors)) > 1.8 or errors[0] < 1e-12, errors


@pytest.mark.parametrize("loop", ["data-driven", "generated"])
def test_singular_positions_are_passed_with_second_order(loop):
    """Two four-bars side by side lie flat, with three freedoms instead of one, four times; at any step they
    stay the parallelograms they are.
    """
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4) if loop == "generated" else (1e-3, 5e-4, 2.5e-4, 1e-4, 2e-5):
        record = run(assemble(double_four_bar(), step, duration=3.0, outputs=100, force_step=True), loop=loop)
        assert record.status == "complete"
        angle = record.block("particle_theta")
        assert np.abs(angle[:, 1] - angle[:, 3]).max() < 1e-3
        rates = solved(
            lambda time, y: np.array([y[1], -3.5 * 9.81 * np.cos(y[0]) / 3.0]),
            [0.5 * np.pi, -1.0],
            np.array([3.0]),
        )
        errors.append(abs(angle[-1, 1] - rates[0, 0]) / step**2)
    assert max(errors) < 100.0, errors  # rad/s^2: fifteen at coarse steps, where the passage itself is exact


@pytest.mark.parametrize("path_unit", [4, 25])
def test_path_units_of_a_frame(path_unit):
    """Elements whose reference is renewed less often: the same motion of a frame that bends and flies."""

    def tip(unit: int) -> np.ndarray:
        m = Mechanism("frame")
        nodes = {"a": (0.0, 0.0), "b": (0.3, 0.0), "c": (0.3, 0.2)}
        members = (Member("a", "b", 2), Member("b", "c", 2))
        m.frame(
            "frame",
            nodes=nodes,
            members=members,
            section=Section.round(0.02),
            material=RUBBER,
            velocity=(0.1, 0.2, 6.0),
        )
        m.loads["push"] = PointForce(
            name="push",
            at="frame.c",
            force=(0.0, 3.0),
            times=(0.0, 0.02, 0.04, 0.06, 0.1, 0.2),
            factors=(0.0, 1.0, 0.0, 0.0, 0.0, 0.0),
        )
        record = run(
            assemble(with_settings(m, path_unit=unit), 1e-5, duration=0.2, outputs=100, force_step=True),
            loop="data-driven",
        )
        return np.stack([record.block("particle_x"), record.block("particle_y")])

    one, many = tip(1), tip(path_unit)
    assert np.ptp(one) > 0.1
    assert 0.0 < np.abs(one - many).max() < 1e-5 * path_unit
