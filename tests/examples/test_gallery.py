"""Every mechanism of the gallery is the same as function and as model file, and comes to a number that was
not made here.
"""

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import vfife
from choice import default_cases
from gallery_runs import run
from independent import chain_of_springs, circles, contact, double_pendulum, integrate_impacts, jansen_foot
from vfife import gallery
from vfife.cli.commands.new import templates
from vfife.files import GALLERY
from vfife.simulation.result import Result
from vfife_validation.published.free_guide import rigid_motion

EXAMPLES = Path(__file__).parents[2] / "examples"


def pin(result: Result, body: str, at: str) -> np.ndarray:
    from vfife.measures.motion import pin_path

    return pin_path(result.record, body, at)


# ------------------------------------------------------------------------------------------------------
# function and file


def plain(value: Any) -> Any:
    """Nouns as dictionaries, lists and numbers; what a file says in words only is left out."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = (field.name for field in dataclasses.fields(value) if field.name not in ("source", "note"))
        return {"a": type(value).__name__, **{name: plain(getattr(value, name)) for name in names}}
    if isinstance(value, dict):
        return {key: plain(one) for key, one in value.items()}
    return [plain(one) for one in value] if isinstance(value, list | tuple) else value


def differences(a: Any, b: Any, where: str = "") -> list[str]:
    """Where two of them differ: names exactly, numbers (rounded in the file) by more than a
    hundred-thousandth.
    """
    if isinstance(a, dict) and isinstance(b, dict):
        missing = [f"{where}.{key}" for key in a.keys() ^ b.keys()]
        return missing + [
            text for key in a.keys() & b.keys() for text in differences(a[key], b[key], f"{where}.{key}")
        ]
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        return [
            text
            for k, (one, other) in enumerate(zip(a, b, strict=True))
            for text in differences(one, other, f"{where}[{k}]")
        ]
    if isinstance(a, float | int) and isinstance(b, float | int):
        return [] if a == pytest.approx(b, rel=1e-5, abs=1e-9) else [f"{where}: {a} {b}"]
    if where.endswith("material.name"):
        return []
    return [] if a == b else [f"{where}: {a} {b}"]


def test_there_is_a_file_for_every_function_and_a_function_for_every_file():
    assert {path.stem for path in EXAMPLES.glob("*.toml")} == set(gallery.__all__)


@pytest.mark.parametrize("name", gallery.__all__)
def test_function_and_file_are_equal(name: str):
    assert (
        differences(plain(getattr(gallery, name)()), plain(vfife.load_model(EXAMPLES / f"{name}.toml"))) == []
    )


def test_the_slider_crank_to_start_from_is_that_of_the_gallery():
    template = vfife.load_model(templates()["slider-crank"])
    assert (
        differences(
            plain(gallery.slider_crank_loose_pin(clearance=5e-5, friction=0.05, turns=3.0)), plain(template)
        )
        == []
    )
    for name in ("slider_crank", "slider_crank_loose_guide"):
        other = getattr(gallery, name)()
        assert [
            differences(plain(template.bodies[body]), plain(other.bodies[body])) for body in ("crank", "rod")
        ] == [[], []]


def test_the_gallery_is_the_examples_and_new_offers_all_of_it():
    assert EXAMPLES == GALLERY
    assert {path for path in templates().values() if path.parent == EXAMPLES} == set(EXAMPLES.glob("*.toml"))


PARAMETERS = {  # of a function: paths of the numbers that it changes
    "block_on_incline": {
        "friction": (
            0.2,
            {"joints.lower.friction.coefficient": 0.2, "joints.upper.friction.coefficient": 0.2},
        ),
        "slope": (0.1, {"bodies.block.angle": 0.1, "joints.upper.direction": (math.cos(0.1), math.sin(0.1))}),
    },
    "compressor": {"wear": (3.0, {"joints.big-end.clearance": 6e-5, "joints.cylinder.clearance": 1.2e-4})},
    "double_pendulum": {"masses": ((2.0, 3.0), {"bodies.upper.mass": 2.0, "bodies.lower.mass": 3.0})},
    "elastic_pendulum": {
        "elements": (24, {"bodies.rod.elements": 24}),
        "diameter": (0.02, {"bodies.rod.section.area": 1e-4 * math.pi}),
    },
    "elastica_circle": {"length": (2.0, {"bodies.strip.length": 2.0, "loads.end.moment": 134.04129 / 2.0})},
    "four_bar_loose": {"friction": (0.2, {f"joints.{name}.friction.coefficient": 0.2 for name in "BCD"})},
    "jansen_leg_loose": {"clearance": (2e-4, {f"joints.{name}.clearance": 2e-4 for name in "CG"})},
    "piston_slap": {"restitution": (0.5, {"joints.guide.contact.restitution": 0.5})},
    "slider_crank_free": {"clearance": (2e-3, {"joints.guide.clearance": 2e-3})},
    "four_bar": {
        "clearance": (1e-4, {f"joints.{name}.clearance": 1e-4 for name in "BCD"}),
        "turns": (3.0, {"settings.turns": 3.0}),
    },
    "gear_train": {
        "ratios": ((-0.3, -0.7), {"gears.first-stage.ratio": -0.3, "gears.second-stage.ratio": -0.7})
    },
    "jansen_leg": {
        "unit": (
            0.02,
            {"bodies.crank.length": 0.3, "bodies.crank.mass": 0.15, "bodies.foot.inertia": 8 * 0.03354659},
        ),
        "density": (1.0, {"bodies.crank.mass": 0.15, "bodies.foot.inertia": 2 * 0.03354659}),
    },
    "journal_in_bearing": {
        "speed": (2.0, {"bodies.journal.velocity": (2.0, 0.0, 0.0), "settings.duration": 5e-4})
    },
    "lee_frame": {"elements": (20, {"bodies.frame.members": (20, 4, 16)})},
    "quick_return": {
        "rocker": (
            0.6,
            {"bodies.rocker.length": 0.6, "bodies.link.length": 0.24, "points.guide": (0.0, 0.612)},
        )
    },
    "scissor_lift": {
        "arm": (2.0, {"bodies.rising-1.length": 2.0, "bodies.platform.pins.edge": (2.0, 0.0)}),
        "load": (9.0, {"bodies.platform.mass": 9.0}),
    },
    "scotch_yoke": {"crank": (0.1, {"bodies.crank.length": 0.1, "bodies.yoke.pins.rod": (0.3, 0.0)})},
    "slider_crank_loose_guide": {"friction": (0.1, {"joints.guide.friction.coefficient": 0.1})},
    "slider_crank_loose_pin": {"restitution": (0.7, {"joints.pin.contact.restitution": 0.7})},
    "squeezer": {"torque": (0.1, {"drivers.motor.value": 0.1}), "outputs": (9, {"settings.outputs": 9})},
    "toggle_press": {"arm": (0.4, {"bodies.upper.length": 0.4, "points.table": (0.0, -1.0)})},
    "williams_toggle": {"drops": ((0.1, 0.2), {"settings.load_factors": (0.1, 0.2)})},
}


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_parameter_replaces_numbers_of_the_file(name: str):
    for parameter, (value, expected) in PARAMETERS[name].items():
        changed = getattr(gallery, name)(**{parameter: value})
        for where, number in expected.items():
            found: Any = changed
            for part in where.split("."):
                found = found[part] if isinstance(found, dict) else getattr(found, part)
            if where.endswith("members"):
                found = tuple(member.elements for member in found)
            assert found == pytest.approx(number, rel=1e-6), (parameter, where)


def test_any_number_is_set_by_its_path():
    assert gallery.load("four_bar", {"joint.C.clearance": "0.3 mm"}) == vfife.load(
        EXAMPLES / "four_bar.toml", {"joint.C.clearance": "0.3 mm"}
    )
    with pytest.raises(vfife.VfifeError, match="clearence"):
        gallery.load("four_bar", {"joint.C.clearence": 1.0})


def test_a_difference_is_seen():
    assert differences(plain(gallery.slider_crank()), plain(gallery.slider_crank(speed=100.01))) == [
        ".drivers.crank.speed: 100.0 100.01"
    ]


def test_every_mechanism_has_a_number():
    assert set(gallery.__all__) == set(MEASURED) | set(NUMBERS)


# ---------------------------------------------------------------------------------------------------- numbers


def block_on_incline() -> tuple[float, float, float]:
    """Uniform acceleration g (sin - f cos)."""
    way = pin(run("block_on_incline"), "block", "center")
    slope = math.radians(30.0)
    return (
        float(np.linalg.norm(way[-1] - way[0])),
        9.81 * (math.sin(slope) - 0.3 * math.cos(slope)) * 0.5**2 / 2.0,
        1e-5,
    )


def swinging_twice() -> tuple[float, float, float]:
    """Lagrange's two equations by another integrator."""
    angles = [
        run("double_pendulum").data["body_angle"].sel(body=name).values[-1] for name in ("upper", "lower")
    ]
    exact = double_pendulum((0.5, 0.4), (1.0, 0.6), (0.0, math.radians(45.0)), 2.0)
    assert angles[0] == pytest.approx(exact[0], rel=1e-4)
    return angles[1], exact[1], 1e-5


def soft_rubber() -> tuple[float, float, float]:
    """A chain of masses with springs along and across, of 20 and 40 pieces, extrapolated to none; the rod of
    12 and 24 elements as well.
    """
    found = []
    for result in (
        run("elastic_pendulum"),
        vfife.simulate(gallery.elastic_pendulum(elements=24), reference=False, loop="data-driven"),
    ):
        found.append(float(pin(result, "rod", "end")[np.argmin(np.abs(result.time - 0.5)), 1]))
    coarse, fine = (chain_of_springs(pieces, 0.5)[1] for pieces in (20, 40))
    return (4.0 * found[1] - found[0]) / 3.0, (4.0 * fine - coarse) / 3.0, 2e-5


def gear_train() -> tuple[float, float, float]:
    """A motor with a straight curve: w = w0 (1 - exp(-t/T)) with all inertias seen from its shaft."""
    inertia = 1e-3 + 0.4**2 * 4e-3 + (0.4 * 0.5) ** 2 * 0.05
    speed = run("gear_train").data["body_angular_velocity"].sel(body="flywheel").values[-1]
    return speed, 0.2 * 300.0 * (1.0 - math.exp(-0.6 * 2.0 / (300.0 * inertia))), 1e-5


def jansen_leg() -> tuple[float, float, float]:
    """Step length from intersecting circles."""
    foot = pin(run("jansen_leg"), "foot", "third")
    exact = 0.01 * np.array([jansen_foot(angle) for angle in np.linspace(0.0, 2.0 * math.pi, 3601)])
    assert np.ptp(foot[:, 1]) == pytest.approx(np.ptp(exact[:, 1]), rel=1e-4)
    return float(np.ptp(foot[:, 0])), float(np.ptp(exact[:, 0])), 1e-4


def four_bar_loose() -> tuple[float, float, float]:
    """The rocker ends at the angle that Siconos' reference file states; the crank on the file's."""
    angles = run("four_bar_loose").data["body_angle"]
    assert angles.sel(body="crank").values[-1] == pytest.approx(4.238456, abs=1e-3)
    return float(angles.sel(body="rocker").values[-1]), 1.995552, 1e-3


def jansen_leg_loose() -> tuple[float, float, float]:
    """The clearance of 0.1 mm in two pins moves the foot little: the step is that of the circles."""
    return float(np.ptp(pin(run("jansen_leg_loose"), "foot", "third")[:, 0])), jansen_leg()[1], 2e-3


def slider_crank_free() -> tuple[float, float, float]:
    """A time stepping of rigid bodies with rigid contacts makes as many turns."""
    turns = run("slider_crank_free").data["body_angle"].sel(body="crank").values[-1] / (2.0 * math.pi)
    return float(turns), float(rigid_motion(1e-4).turns[-1]), 2e-3


def piston_slap() -> tuple[float, float, float]:
    """Up to its first impact the block hangs on the rod, a pendulum about the driven crank pin."""
    speed, step = 2000.0 * math.pi / 30.0, 1e-7
    moment, inertia = 0.21 * 0.06 + 0.14 * 0.12, 2.5e-4 + 0.21 * 0.06**2 + 0.14 * 0.12**2
    time, angle, rate = 0.0, 0.0, -0.05 * speed / 0.12

    def height(angle: float, time: float) -> float:
        return 0.05 * math.sin(speed * time) + 0.12 * math.sin(angle)

    while abs(height(angle, time)) < 0.5e-3:
        x, y = (-0.05 * speed**2 * along(speed * time) for along in (math.cos, math.sin))
        rate += step * moment / inertia * (math.sin(angle) * x - math.cos(angle) * (y + 9.81))
        angle, time = angle + step * rate, time + step
    result = run("piston_slap")
    heights = np.abs(np.asarray(result.series["block.y"]))
    after = int(np.argmax(heights >= 0.5e-3))
    near = slice(after - 1, after + 1)
    return float(np.interp(0.5e-3, heights[near], np.asarray(result.time)[near])), time, 2e-3


def lee_frame() -> tuple[float, float, float]:
    """Limit load published since Lee, Manuel and Rossow 1968: 1.855 kN."""
    force = run("lee_frame").data["joint_force"].sel(joint="push").values
    assert force[-1] < force.max()
    return float(force.max()), 1855.2, 7e-3


def quick_return() -> tuple[float, float, float]:
    """Time of stroke over time of return."""
    result = run("quick_return")
    angle = result.data["body_angle"].sel(body="rocker").values[:-1]
    turned = np.array([_peak(angle), _peak(-angle)])
    share = abs(turned[1] - turned[0]) / len(angle)
    half = math.asin(0.1 / 0.25)
    assert np.ptp(angle) == pytest.approx(2.0 * half, rel=1e-5)
    return (
        max(share, 1.0 - share) / min(share, 1.0 - share),
        (math.pi + 2.0 * half) / (math.pi - 2.0 * half),
        1e-4,
    )


def _peak(values: np.ndarray) -> float:
    """Place of the largest value between the samples, by a parabola."""
    k = int(np.argmax(values))
    a, b, c = values[k - 1], values[k], values[(k + 1) % len(values)]
    return k + 0.5 * (a - c) / (a - 2.0 * b + c)


def scissor_lift() -> tuple[float, float, float]:
    """Lagrange's equation of its one motion, x the way of the roller from the fixed foot."""
    t = np.linspace(0.0, 2.0, 4001)
    s = t / 2.0
    step, rate, second = (
        -0.3 * v
        for v in (s**3 * (10 - 15 * s + 6 * s**2), 15 * s**2 * (1 - s) ** 2, 15 * s * (1 - s) * (1 - 2 * s))
    )
    x = math.cos(math.radians(20.0)) + step

    def inertia(x):
        slope = x / np.sqrt(1.0 - x**2)  # -dh/dx, and 1/sin = -d(angle)/dx
        return 200.0 * 4.0 * slope**2 + 5.0 * (1.0 + 5.0 * slope**2) + 4.0 * 5.0 / 12.0 / (1.0 - x**2)

    weight = -9.81 * (2.0 * 200.0 + 4.0 * 5.0) * x / np.sqrt(1.0 - x**2)
    steep = (inertia(x + 1e-6) - inertia(x - 1e-6)) / 2e-6
    force = inertia(x) * second + 0.5 * steep * rate**2 + weight
    return run("scissor_lift").measures["actuator.force.max"], float(np.abs(force).max()), 1e-4


def scotch_yoke() -> tuple[float, float, float]:
    """m r^2 w^2/2."""
    return run("scotch_yoke").measures["crank.torque.max"], 2.0 * 0.05**2 * (20.0 * math.pi) ** 2 / 2.0, 1e-5


def six_bar_press() -> tuple[float, float, float]:
    """Stroke of the ram from two pairs of circles."""
    ram = pin(run("six_bar_press"), "ram", "center")[:, 0]
    exact = []
    for angle in np.linspace(0.0, 2.0 * math.pi, 3601):
        b, d = 0.08 * np.array([math.cos(angle), math.sin(angle)]), np.array([0.35, 0.05])
        e = d + (circles(b, 0.32, d, 0.22, -1.0) - d) * 0.30 / 0.22
        exact.append(e[0] + math.sqrt(0.45**2 - (e[1] + 0.22) ** 2))
    return float(np.ptp(ram)), float(np.ptp(exact)), 1e-4


def compressed() -> tuple[float, float, float]:
    """Power of the ideal compressor: the area of its indicator diagram, once a turn."""
    result = vfife.simulate(gallery.compressor(wear=0.0, turns=1.0))
    table = gallery.compressor().loads["gas"]
    up, down = (PchipInterpolator(table.travels, values) for values in (table.pressure, table.pressure_back))
    work = 0.25 * math.pi * 0.065**2 * (up.integrate(-0.046, 0.0) - down.integrate(-0.046, 0.0))
    return result.measures["crank.power.mean"], float(work) * 1450.0 / 60.0, 1e-4


def test_the_crank_pin_of_the_compressor_is_the_journal_and_wears_over_an_arc():
    """The rod pulls and presses along itself: the load stays in place in its bore and travels around the
    crank pin. The piston pin lies in the other bore of the rod.
    """
    model = gallery.compressor()
    sides = {name: [side[0] for side in model.joints[name].sides] for name in ("big-end", "small-end")}
    assert sides == {"big-end": ["rod", "crank"], "small-end": ["rod", "piston"]}
    around = {side: run("compressor").around(side, bins=12) for side in ("bearing", "journal")}
    k = around["bearing"].names.index("big-end")
    rod, crank = (one.friction[k].max() / one.friction[k].sum() for one in around.values())
    assert rod > 0.6 and crank < 0.3, (rod, crank)


def slider_crank() -> tuple[float, float, float]:
    """At the dead centre r w^2 (1 + r/l)."""
    return (
        run("slider_crank").data["particle_ax"].sel(particle="block").values[0],
        -0.05 * 100.0**2 * (1.0 + 0.05 / 0.12),
        1e-5,
    )


def loose_pin() -> tuple[float, float, float]:
    """Rod and block under a prescribed crank, impacts located as events."""
    stiffness = contact(radius=0.01 * 0.0095 / 0.0005)

    def motion(t, q, force):
        place, rate, pull = _rod(t, q[0], q[2])
        away, speed = np.array([q[1], 0.0]) - place, np.array([q[3], 0.0]) - rate
        size = float(np.hypot(*away))
        n = away / max(size, 1e-12)
        push = force(0, size - 0.5e-3, float(n @ speed))
        turn = (_cross(_arm(q[0]), push * n) - 0.21 * 0.5 * _cross(_arm(q[0]), pull)) / (
            2.5e-4 + 0.21 * 0.06**2
        )
        return [q[2], q[3], turn, -push * n[0] / 0.14]

    start = [0.0, 0.17, -0.05 * 100.0 / 0.12, 0.0]
    return (
        run("slider_crank_loose_pin").measures["pin.force.max"],
        integrate_impacts(motion, start, 0.01 * math.pi, 1, stiffness, 0.9),
        2e-3,
    )


def loose_guide() -> tuple[float, float, float]:
    """Rod, and block turning about its pin, under a prescribed crank; four corners and two walls."""
    stiffness = contact(radius=1e-3)

    def motion(t, q, force):
        place, rate, pull = _rod(t, q[0], q[2])
        along, across = (
            np.array([math.cos(q[1]), math.sin(q[1])]),
            np.array([-math.sin(q[1]), math.cos(q[1])]),
        )
        total, moment = 0.0, 0.0
        for k, (front, side) in enumerate(((-1, 1), (1, 1), (-1, -1), (1, -1))):
            at = front * 0.029 * along + side * 0.014 * across  # seen from the middle
            y, rise = place[1] + 0.01 * along[1] + at[1], rate[1] + q[3] * (0.01 * along[0] + at[0])
            push = -side * force(k, side * y - 0.0145, side * rise)
            total, moment = total + push, moment + at[0] * push
        arm = _arm(q[0])
        turn = np.array([-arm[1], arm[0]])
        left = np.array([0.0, total]) - 0.14 * (pull - q[2] ** 2 * arm - 0.01 * q[3] ** 2 * along)
        shared = 0.14 * 0.01 * float(turn @ across)
        inertia = [[2.5e-4 + 0.21 * 0.06**2 + 0.14 * 0.12**2, shared], [shared, 1e-4 + 0.14 * 0.01**2]]
        return [
            q[2],
            q[3],
            *np.linalg.solve(inertia, [turn @ (left - 0.21 * 0.5 * pull), 0.01 * across @ left + moment]),
        ]

    start = [0.0, 0.0, -0.05 * 100.0 / 0.12, 0.0]
    exact = integrate_impacts(motion, start, 0.01 * math.pi, 4, stiffness, 0.9)
    return run("slider_crank_loose_guide").measures["guide.force.max"], exact, 2e-3


def _arm(angle: float) -> np.ndarray:
    return 0.12 * np.array([math.cos(angle), math.sin(angle)])


def _cross(a: np.ndarray, b: np.ndarray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _rod(t: float, angle: float, rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Place and velocity of the rod's end, and the acceleration of its beginning on the crank."""
    c, s = math.cos(100.0 * t), math.sin(100.0 * t)
    arm = _arm(angle)
    place = np.array([0.05 * c, 0.05 * s]) + arm
    speed = np.array([-5.0 * s, 5.0 * c]) + rate * np.array([-arm[1], arm[0]])
    return place, speed, np.array([-500.0 * c, -500.0 * s])


def squeezer() -> tuple[float, float, float]:
    """Reference solution of the test set for initial value problems (Mazzia and Magherini) at 0.03 s."""
    angles = run("squeezer").data["body_angle"].sel(body=["K1", "K3", "K5", "K7"]).values[-1]
    published = (15.81077119629904, 0.04082224013073101, 0.5244099658805304, 1.048080741042263)
    for found, exact in zip(angles[1:], published[1:], strict=True):
        assert found == pytest.approx(exact, abs=1e-7)
    return angles[0], published[0], 1e-6


def toggle_press() -> tuple[float, float, float]:
    """Equilibrium of the knee: 2 k arm (cos a - cos a0) = hand/(2 tan a), found by bisection."""
    from scipy.optimize import brentq

    bent = math.radians(20.0)
    a = brentq(lambda a: 2e5 * 0.4 * (math.cos(a) - math.cos(bent)) * math.tan(a) - 400.0 / 2.0, 0.3, bent)
    return run("toggle_press").measures["wrist.force.max"], 400.0 / (2.0 * math.sin(a)), 1e-5


def elastica_circle() -> tuple[float, float, float]:
    """A quarter and a half of a circle, and at last a whole one."""
    end = pin(run("elastica_circle"), "strip", "end")
    assert end[1] == pytest.approx([2.0 / math.pi, 2.0 / math.pi], rel=2e-3)
    assert np.hypot(*end[-1]) < 1e-3
    return end[2][1], 2.0 / math.pi, 5e-3


def williams_toggle() -> tuple[float, float, float]:
    """Limit load of the shallow toggle: 34 lb (Williams 1964)."""
    result = run("williams_toggle")
    force = result.data["joint_force"].sel(joint="push").values
    before = result.time < 0.3
    assert force[result.time == 0.3922] < force[before].max()
    return float(force[before].max()) / 4.4482216, 34.0, 1e-2


LONG = ("elastica_circle", "williams_toggle", "slider_crank_loose_guide", "slider_crank_free")
NUMBERS: dict[str, Callable[[], tuple[float, float, float]]] = {
    "block_on_incline": block_on_incline,
    "compressor": compressed,
    "double_pendulum": swinging_twice,
    "elastic_pendulum": soft_rubber,
    "elastica_circle": elastica_circle,
    "four_bar_loose": four_bar_loose,
    "gear_train": gear_train,
    "jansen_leg": jansen_leg,
    "jansen_leg_loose": jansen_leg_loose,
    "lee_frame": lee_frame,
    "piston_slap": piston_slap,
    "quick_return": quick_return,
    "scissor_lift": scissor_lift,
    "scotch_yoke": scotch_yoke,
    "six_bar_press": six_bar_press,
    "slider_crank": slider_crank,
    "slider_crank_free": slider_crank_free,
    "slider_crank_loose_guide": loose_guide,
    "slider_crank_loose_pin": loose_pin,
    "squeezer": squeezer,
    "toggle_press": toggle_press,
    "williams_toggle": williams_toggle,
}


# Of independent references with located onsets, and of the ideal motion; see the files.
MEASURED = {
    "four_bar": ("follower.angular_acceleration.lip", 31.6, 0.5),
    "four_bar_ideal": ("follower.angular_acceleration.max", 22816.05, 5.0),
    "four_bar_case_b": ("C.force.max", 65794.78, 70.0),
    "four_bar_case_c": ("follower.angular_acceleration.max", 38153.31, 190.0),
    "journal_in_bearing": ("O.force.max", 23221.0, 2.3),
}


@pytest.mark.parametrize("name", MEASURED)
def test_the_measure_holds(name: str):
    measure, value, tolerance = MEASURED[name]
    result = vfife.simulate(getattr(gallery, name)())
    assert result.record.status == "complete"
    assert result.measures[measure] == pytest.approx(value, abs=tolerance)


@pytest.mark.parametrize(
    "name", default_cases(NUMBERS, lambda name: name not in LONG, "runs or relaxes a long model")
)
def test_the_number_holds(name: str):
    found, exact, share = NUMBERS[name]()
    assert found == pytest.approx(exact, rel=share)
