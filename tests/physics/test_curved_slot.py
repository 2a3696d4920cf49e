"""A pin in a curved slot, ideal and with clearance, against a pendulum, a slider, energy and forces in closed
form.
"""

import dataclasses
import math

import numpy as np
import pytest

from support import bits, go, lanes, order, particle, times
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.loops import python_line
from vfife.kinematics.initial import ideal_motion
from vfife.laws import Ambrosio, Frictionless, LankaraniNikravesh
from vfife.measures.energy import ledger
from vfife.measures.forces import joint_force, normals
from vfife.model.drivers import ConstantSpeed
from vfife.model.geometry.path import circle, polyline
from vfife.model.joints import ClearanceCurvedSlot, CurvedSlot, Slider
from vfife.model.mechanism import Mechanism

GRAVITY = 9.81
AFTER_1_S = (
    0.986291751,
    -0.165010853,
)  # m: a rigid pendulum of 1 m, let go from (-1, 0); its period is 2.36784194758 s
VALLEY = ((-1.0, 0.5), (-0.2, -0.1), (0.3, -0.1), (1.0, 0.6))
SOFT = {"contact": LankaraniNikravesh(restitution=0.5, stiffness=1e8), "friction": Frictionless()}


def bead(joint, at=(-1.0, 0.0), gravity=(0.0, -GRAVITY), inertia=0.01, **body):
    """A body of 1 kg whose pin runs in a slot of the ground, let go from rest."""
    m = Mechanism("bead", gravity=gravity)
    m.point("O", 0.0, 0.0)
    m.rigid_body("bead", mass=1.0, inertia=inertia, position=at, **body)
    m.joints["slot"] = joint
    return m


def slot(kind=CurvedSlot, **options):
    return kind(name="slot", bearing="ground.O", journal="bead.center", **options)


# --------------------------------------------------------------------------------------------------- the path


def test_a_fillet_touches_both_pieces_and_the_path_has_no_corner():
    path = polyline(VALLEY, 0.1)
    assert [piece.curvature for piece in path.pieces] == pytest.approx([0.0, 10.0, 0.0, 10.0, 0.0])
    for one, two in zip(path.pieces, path.pieces[1:], strict=False):
        assert one.end == two.begin and one.end_tangent == two.tangent
        assert path.nearest(*one.end) == pytest.approx(
            (0.0, -one.end_tangent[1], one.end_tangent[0]), abs=1e-12
        )
    arc = path.pieces[1]
    centre = np.array(arc.begin) + 0.1 * np.array([-arc.tangent[1], arc.tangent[0]])
    assert np.linalg.norm(np.array(arc.points()) - centre, axis=1) == pytest.approx(0.1, abs=1e-15)


def test_the_distance_from_a_path_is_that_of_its_nearest_point():
    """Against a search among very many points of the path, on both sides and beyond the ends."""
    rng = np.random.default_rng(4)
    for path in (
        polyline(VALLEY, 0.2),
        circle((0.1, -0.2), 0.7),
        polyline(((0, 0), (1, 0), (1, 1), (0.2, 1)), 0.3),
    ):
        dense = np.concatenate(
            [
                np.array(piece.points(1e-3)) if piece.curvature else np.linspace(piece.begin, piece.end, 4000)
                for piece in path.pieces
            ]
        )
        for point in rng.uniform(-0.3, 1.0, (60, 2)):
            away = np.linalg.norm(dense - point, axis=1)
            if 0 < away.argmin() < len(dense) - 1 or path.pieces[0].curvature:
                distance, nx, ny = path.nearest(*point)
                assert abs(distance) == pytest.approx(away.min(), abs=1e-5)
                assert path.nearest(*(point - distance * np.array([nx, ny])))[0] == pytest.approx(
                    0.0, abs=1e-12
                )  # the normal leads to the foot


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "give a radius or points"),
        ({"points": ((0, 0), (1, 0), (1, 1))}, "corner at point 2 and no fillet"),
        ({"points": ((0, 0), (1, 0), (1, 1)), "fillet": 2.0}, "take 2 m of the 1 m between points 1 and 2"),
        ({"points": ((0, 0), (0, 0))}, "make no straight piece"),
        ({"points": ((0, 0), (1, 0), (0, 1e-3)), "fillet": 1e-3}, "turns back at point 2"),
    ],
)
def test_a_slot_that_is_none_is_told(options, words):
    with pytest.raises(ValueError, match=rf"joint\.slot.*(?i:{words})"):
        slot(**options).rows()


def test_a_slot_too_narrow_for_its_pin_is_told():
    with pytest.raises(ValueError, match="leaves no inner wall"):
        slot(ClearanceCurvedSlot, clearance=1e-3, journal_radius=0.2, radius=0.2).touchings(0.0)


# ------------------------------------------------------------------------------------------------------ ideal


def test_a_bead_on_a_circle_is_a_pendulum():
    """Second order in the step to the position of the pendulum, on the circle to round-off."""
    errors = []
    for step in (2e-3, 1e-3, 5e-4):
        found = particle(go(bead(slot(radius=1.0)), step, duration=1.0, outputs=1), "bead")
        errors.append(math.hypot(found["x"][-1] - AFTER_1_S[0], found["y"][-1] - AFTER_1_S[1]))
        assert math.hypot(found["x"][-1], found["y"][-1]) == pytest.approx(1.0, abs=1e-12)
    assert min(order(errors)) == pytest.approx(2.0, abs=0.02) and errors[-1] < 1e-6


def test_acceleration_and_reaction_at_the_start_have_the_curvature_term():
    """Thrown along the circle: m (v^2/R + g) at its bottom, v^2/R towards the centre, from
    kinematics alone.
    """
    motion = ideal_motion(bead(slot(radius=0.5), at=(0.0, -0.5), velocity=(3.0, 0.0, 0.0)))
    assert motion.reaction["slot"][:2] == pytest.approx((0.0, 9.0 / 0.5 + GRAVITY), rel=1e-12)
    assert motion.of("bead")[2][:2] == pytest.approx((0.0, 9.0 / 0.5), rel=1e-12, abs=1e-12)


def test_on_a_straight_piece_a_slot_is_a_slider():
    straight = slot(points=((-1.0, 0.5), (1.0, -0.5)))
    line = Slider(name="slot", bearing="ground.O", journal="bead.center", direction=(2.0, -1.0), turning=True)
    ours, theirs = (
        particle(go(bead(j, at=(-1.0, 0.5)), 1e-3, duration=0.3, outputs=10), "bead")
        for j in (straight, line)
    )
    assert ours["x"][-1] - ours["x"][0] > 0.1
    for name in ("x", "y", "u", "v"):
        assert ours[name] == pytest.approx(theirs[name], abs=1e-11)


def test_over_pieces_of_a_polyline_energy_is_kept_and_the_pin_stays_on_it():
    m = bead(slot(points=VALLEY, fillet=0.15), at=(-0.9, 0.425))
    record = go(m, 1e-4, duration=1.5, outputs=300)
    found = particle(record, "bead")
    path = m.joints["slot"].path
    assert max(abs(path.distance(x, y)) for x, y in zip(found["x"], found["y"], strict=True)) < 1e-12
    assert found["x"].max() > 0.4 and found["x"][-1] < found["x"].max()  # over both corners, and back
    height = 0.425 - found["y"]
    speed = 0.5 * (found["u"] ** 2 + found["v"] ** 2)  # half a step later: v^2/2 changes by g v dt
    assert np.abs(speed - GRAVITY * height).max() < 1.1 * 0.5e-4 * GRAVITY * 4.0
    assert ledger(record).error < 1e-4


def turning_slot(kind=CurvedSlot, lane=0, **options):
    """A driven disc with a slot in which the pin of a rocker runs: both of its bodies move."""
    m = Mechanism("cam")
    m.point("O", 0.0, 0.0)
    m.point("P", 0.5 + 0.001 * lane, 0.0)
    m.rigid_body("disc", mass=2.0, inertia=0.05, pins={"hub": (0.0, 0.0)})
    m.rigid_body(
        "rocker", mass=0.4, inertia=4e-3, pins={"foot": (0.0, 0.0), "pin": (0.4, 0.0)}, angle=math.pi - 0.3
    )
    m.revolute("O", "ground.O", "disc.hub")
    m.revolute("P", "ground.P", "rocker.foot")
    m.joints["slot"] = kind(name="slot", bearing="disc.hub", journal="rocker.pin", **options)
    m.drivers["disc"] = ConstantSpeed(body="disc", speed=12.0 + lane)
    return m


GROOVE = {"points": ((-0.1, 0.3), (0.1, 0.1), (0.15, -0.2), (0.4, -0.3)), "fillet": 0.08}


def test_a_slot_that_turns_moves_its_pin_as_its_path_says():
    """The pin of the rocker, seen from the disc, stays on the path; what the driver gives is the energy of
    rocker and disc.
    """
    m = turning_slot(**GROOVE)
    record = go(m, 2e-5, duration=0.06, outputs=100)
    path, angle = m.joints["slot"].path, particle(record, "rocker")["theta"]
    x, y = 0.5 + 0.4 * np.cos(angle), 0.4 * np.sin(angle)
    turned = 12.0 * times(record)
    seen = np.cos(turned) * x + np.sin(turned) * y, np.cos(turned) * y - np.sin(turned) * x
    assert max(abs(path.distance(a, b)) for a, b in zip(*seen, strict=True)) < 1e-10
    assert np.ptp(angle) > 0.03
    assert ledger(record).error < 1e-4


# -------------------------------------------------------------------------------------------------- with
# clearance


def test_a_pin_at_rest_presses_with_its_weight():
    m = bead(
        slot(ClearanceCurvedSlot, radius=0.5, clearance=1e-4, journal_radius=0.01, **SOFT), at=(0.0, -0.5)
    )
    record = go(m, 1e-5, duration=0.3, outputs=300)
    force = joint_force(record)[-50:, 0].mean(axis=0)
    assert force == pytest.approx((0.0, GRAVITY), abs=1e-2)
    assert normals(record)[-1, 0] == pytest.approx((0.0, -1.0), abs=1e-6)


def test_on_an_arc_it_presses_with_what_turns_its_way():
    """Without gravity along the outer wall at 2 m/s: m v^2/R on average, R that of the pin's centre; and m
    (v^2/R + g) at the bottom.
    """
    options = {"radius": 0.5, "clearance": 1e-3, "journal_radius": 0.01, **SOFT}
    round_ = bead(
        slot(ClearanceCurvedSlot, **options), at=(0.0, -0.501), gravity=(0.0, 0.0), velocity=(2.0, 0.0, 0.0)
    )
    force = np.hypot(*joint_force(go(round_, 1e-5, duration=0.5, outputs=5000))[1000:, 0].T)
    assert force.mean() == pytest.approx(4.0 / 0.501, rel=5e-3)
    hanging = bead(slot(ClearanceCurvedSlot, **options), at=(-0.501, 0.0))
    record = go(hanging, 1e-5, duration=0.6, outputs=6000)
    found, force = particle(record, "bead"), joint_force(record)[:, 0, 1]
    bottom = np.abs(found["x"]) < 0.05
    speed = found["u"][bottom] ** 2 + found["v"][bottom] ** 2
    assert force[bottom].mean() == pytest.approx((speed / 0.501).mean() + GRAVITY, rel=2e-2)


def test_play_goes_to_zero_and_the_motion_to_the_ideal_one():
    ideal = particle(go(bead(slot(radius=0.5), at=(-0.5, 0.0)), 1e-5, duration=0.4, outputs=1), "bead")
    errors = []
    for clearance in (4e-3, 1e-3, 2.5e-4):
        loose = slot(ClearanceCurvedSlot, radius=0.5, clearance=clearance, journal_radius=0.02, **SOFT)
        found = particle(go(bead(loose, at=(-0.5, 0.0)), 1e-5, duration=0.4, outputs=1), "bead")
        errors.append(math.hypot(found["x"][-1] - ideal["x"][-1], found["y"][-1] - ideal["y"][-1]))
    assert errors[0] < 0.05 and min(order(errors, 4.0)) > 0.7


def test_a_pin_on_a_straight_wall_rubs_as_a_block_on_an_incline():
    """Down 45 degrees against Coulomb's friction: a = g (sin - mu cos), with the pin kept from rolling by a
    large inertia.
    """
    rough = {
        "contact": SOFT["contact"],
        "friction": Ambrosio(coefficient=0.2, v0=1e-5, v1=1e-4),
        "friction_moment": "off",
    }
    loose = slot(
        ClearanceCurvedSlot, points=((-1.0, 1.0), (1.0, -1.0)), clearance=1e-5, journal_radius=0.01, **rough
    )
    found = particle(go(bead(loose, at=(-1.0, 1.0)), 1e-5, duration=0.3, outputs=3), "bead")
    along = (found["x"][-1] + 1.0 - found["y"][-1] + 1.0) / math.sqrt(2.0)
    assert along == pytest.approx(0.5 * GRAVITY * (1.0 - 0.2) / math.sqrt(2.0) * 0.09, rel=5e-3)


@pytest.mark.parametrize("moment", ["mid-overlap", "surface"])
@pytest.mark.parametrize(
    "path",
    [{"radius": 0.4, "centre": (0.1, 0.2)}, {"points": VALLEY, "fillet": 0.15}],
    ids=["circle", "polyline"],
)
def test_two_free_bodies_keep_their_momentum_and_its_moment(path, moment):
    """A bead rubs along the slot of a free plate: force and friction on both act at one place, or the sum of
    moments would change.
    """
    m = Mechanism("free")
    loose = {
        "clearance": 1e-3,
        "journal_radius": 0.02,
        "contact": SOFT["contact"],
        "friction": Ambrosio(coefficient=0.3, v0=1e-3, v1=1e-2),
    }
    joint = ClearanceCurvedSlot(
        name="slot", bearing="plate.eye", journal="bead.center", friction_moment=moment, **path, **loose
    )
    x, y = joint.first_place
    m.rigid_body(
        "plate",
        mass=3.0,
        inertia=0.2,
        pins={"eye": (0.0, 0.0)},
        center=(0.3, 0.1),
        position=(0.0, 0.0),
        velocity=(0.2, 0.1, 1.0),
    )
    m.rigid_body("bead", mass=1.0, inertia=1e-3, position=(x, y), velocity=(1.5, 2.0, 20.0))
    m.joints["slot"] = joint
    record = go(m, 1e-5, duration=0.3, outputs=30)
    plate, bead_ = particle(record, "plate"), particle(record, "bead")

    def spin(one, mass, inertia):
        return mass * (one["x"] * one["v"] - one["y"] * one["u"]) + inertia * one["w"]

    total = spin(plate, 3.0, 0.2) + spin(bead_, 1.0, 1e-3)
    rubbed = record.block("contact_friction_work")[-1, 0]
    assert record.block("contact_onsets")[-1, 0] > 0 and rubbed > 1e-3
    apart = (
        0.0 if moment == "mid-overlap" else 1e-3
    )  # at the surfaces friction acts a penetration apart, on purpose
    assert np.ptp(total) < 1e-11 + apart * abs(total[0])
    assert np.ptp(3.0 * plate["u"] + bead_["u"]) < 1e-12


def test_the_mirror_image_moves_as_a_mirror_image():
    def groove(sign):
        points = tuple((x, sign * y) for x, y in VALLEY)
        loose = slot(
            ClearanceCurvedSlot, points=points, fillet=0.2, clearance=2e-3, journal_radius=0.02, **SOFT
        )
        return particle(
            go(
                bead(loose, at=(-0.9, 0.425 * sign), gravity=(0.0, -sign * GRAVITY)),
                1e-4,
                duration=0.5,
                outputs=20,
            ),
            "bead",
        )

    one, other = groove(1.0), groove(-1.0)
    assert one["x"] == pytest.approx(other["x"], abs=1e-9) and one["y"] == pytest.approx(
        -other["y"], abs=1e-9
    )


# -------------------------------------------------------------------------------------------------- all loops

PLAY = {
    "clearance": 3e-4,
    "journal_radius": 0.01,
    "contact": LankaraniNikravesh(restitution=0.7, stiffness=1e9),
    "friction": Ambrosio(coefficient=0.2),
}


@pytest.mark.system("compiles every kind of slot")
@pytest.mark.parametrize("kind", [CurvedSlot, ClearanceCurvedSlot])
@pytest.mark.parametrize(
    "path", [GROOVE, {"radius": 0.35, "centre": (-0.05, 0.02)}], ids=["polyline", "circle"]
)
def test_all_loops_agree_to_the_bit(kind, path):
    """Data-driven, interpreted and the generated text, and four lanes with numbers of their own, over a
    change of pieces.
    """

    def made(lane):
        moved = path | (
            {"fillet": path["fillet"] + 0.002 * lane}
            if "fillet" in path
            else {"radius": path["radius"] + 0.002 * lane}
        )
        return assemble(
            turning_slot(kind, lane, **moved, **(PLAY if kind is ClearanceCurvedSlot else {})),
            2e-5,
            duration=0.06,
            force_step=True,
        )

    assemblies = [made(lane) for lane in range(4)]
    runs = {}
    for loop in ("data-driven", "generated"):
        runner = lanes(assemblies, loop)
        runs[loop] = np.concatenate([runner.advance(1, 1), runner.advance(50, 40)])
    assert np.isfinite(runs["data-driven"]).all()
    assert (bits(runs["data-driven"]) == bits(runs["generated"])).all()
    runner = lanes(assemblies[:1], "interpreted")
    plain = np.concatenate([runner.advance(1, 1), runner.advance(50, 3)])
    assert (bits(plain) == bits(runs["data-driven"][: len(plain), :, :1])).all()
    runner = lanes(assemblies[:1], "interpreted")
    runner.take = python_line(runner.topology)(runner.memory)
    text = np.concatenate([runner.advance(1, 1), runner.advance(50, 3)])
    assert (bits(text) == bits(plain)).all()


def test_the_ideal_reference_of_a_loose_slot_is_the_slot():
    loose = slot(ClearanceCurvedSlot, radius=0.5, clearance=1e-3, journal_radius=0.01)
    assert bead(loose).ideal().joints["slot"] == slot(radius=0.5)
    assert dataclasses.replace(loose, radius=0.4).rows() == slot(radius=0.4).rows()
