"""Shapes and forces of elastic links at the start, against chains laid out by hand, centrifugal force and
cantilevers.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.assembly.prestress import Shape, _inertial, _shape, _turned, as_rigid, straight
from vfife.model.bodies import Section
from vfife.model.lumping import mesh
from vfife.model.mechanism import Mechanism

MASS, LENGTH = 1.2, 0.6


def rod(
    gravity: tuple[float, float] = (0.0, 0.0),
    speed: float = 0.0,
    angle: float = 0.0,
    elements: int = 2,
    **link: Any,
) -> Mechanism:
    """An elastic rod on a pivot that holds it to a speed."""
    m = Mechanism("rod", gravity=gravity)
    m.point("O", 0.0, 0.0)
    m.link(
        "l",
        length=LENGTH,
        mass=MASS,
        angle=angle,
        model="elastic",
        elements=elements,
        section=Section.square(4e-4),
        **link,
    )
    m.revolute("A", "ground.O", "l.start")
    m.drive("l", speed=speed)
    return m


def started(m: Mechanism) -> Assembly:
    return assemble(m, 1e-6, duration=1e-3, force_step=True)


def block(assembly: Assembly, name: str) -> np.ndarray:
    return assembly.state[assembly.layout[name]]


def test_a_chain_is_laid_out_from_its_start() -> None:
    """The first element along x; the next turns by the end rotation before it less its own first one."""
    first, second = np.array([0.1, -0.2]), np.array([0.3, 0.05])
    found = _shape(np.array([0.3, 0.2]), np.zeros(2), np.zeros(2), np.zeros(2), (first, second))
    way = 0.3 + 0.2
    x, y = 0.3 + 0.2 * math.cos(way), 0.2 * math.sin(way)
    assert found.local[:, :2] == pytest.approx(np.array([[0.0, 0.0], [0.3, 0.0], [x, y]]), rel=1e-12)
    assert found.local[:, 2] == pytest.approx([0.1, 0.3, way + 0.05], rel=1e-12)


def test_a_shape_is_turned_back_into_the_frame_of_its_body() -> None:
    local = np.array([[0.0, 0.0, 0.1], [0.6, 0.8, 0.4]])
    angle = math.atan2(0.8, 0.6)
    found = _turned(Shape(local, np.zeros(1), np.zeros(1), np.zeros(1)), angle).local
    assert found == pytest.approx(np.array([[0.0, 0.0, 0.1 - angle], [1.0, 0.0, 0.4 - angle]]), abs=1e-12)


@pytest.mark.parametrize("release", ["none", "start", "end", "both"])
def test_a_link_held_in_its_shape_has_the_mass_centre_and_inertia_of_its_lumps(release: str) -> None:
    """m/4, m/2, m/4 at 0, l/2 and l of a bent shape; the ends' own inertia turns along where they are not
    released.
    """
    link: Any = rod(release=release).bodies["l"]
    bent = straight(link)
    bent.local[1, 1] = 0.05
    body = as_rigid(link, bent)
    masses = np.array([0.25, 0.5, 0.25]) * MASS
    assert body.mass == pytest.approx(MASS) and body.center == pytest.approx((LENGTH / 2.0, 0.025))
    x, y = np.array([-0.3, 0.0, 0.3]), np.array([-0.025, 0.025, -0.025])
    lumps = mesh(link).inertia.copy()
    lumps[[k for k, end in ((0, "start"), (2, "end")) if release in (end, "both")]] = 0.0
    assert body.inertia == pytest.approx(float((masses * (x * x + y * y)).sum() + lumps.sum()), rel=1e-12)
    assert body.pins == {"start": (0.0, 0.0), "end": (LENGTH, 0.0)}


def test_a_turning_rod_is_pulled_by_what_is_beyond() -> None:
    """Of lumps m/4, m/2, m/4 each element holds those further out, m_i w^2 r_i, r that of the
    stretched rod.
    """
    speed = 50.0
    found = started(rod(speed=speed))
    pull = block(found, "frame_axial_force")
    x, y = block(found, "particle_x")[1:], block(found, "particle_y")[1:]
    radius = np.hypot(x, y)
    outer = 0.25 * MASS * speed**2 * radius[2]
    assert pull == pytest.approx([outer + 0.5 * MASS * speed**2 * radius[1], outer], rel=1e-9)
    stretched = 0.3 * (1.0 + pull / (207e9 * 4e-4))
    assert np.diff(radius) == pytest.approx(stretched, rel=1e-12)
    assert block(found, "frame_moment_1") == pytest.approx([0.0, 0.0], abs=1e-9)
    w, u, v = (block(found, f"particle_{name}")[1:] for name in "wuv")
    assert w == pytest.approx([speed] * 3, rel=1e-9) and (u[0], v[0]) == (0.0, 0.0)
    assert np.hypot(block(found, "particle_u")[3], block(found, "particle_v")[3]) == pytest.approx(
        speed * radius[2], rel=1e-9
    )


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_rod_held_under_weight_bends_as_a_cantilever_of_its_lumps(angle: float) -> None:
    """Moments m g r cos of what is beyond, at the pivot and in the middle; none at the free end; pull m g sin
    of what is beyond.
    """
    g = 9.81
    found = started(rod((0.0, -g), angle=angle))
    first, second = block(found, "frame_moment_1"), block(found, "frame_moment_2")
    x, y = block(found, "particle_x")[1:], block(found, "particle_y")[1:]
    middle = 0.25 * MASS * g * (x[2] - x[1])
    pivot = 0.5 * MASS * g * x[1] + 0.25 * MASS * g * x[2]
    assert np.abs([first[0], second[0], first[1]]) == pytest.approx([pivot, middle, middle], rel=1e-6)
    assert second[1] == pytest.approx(0.0, abs=1e-6 * pivot) and first[1] == pytest.approx(
        -second[0], rel=1e-6
    )
    along = (np.diff(y) / np.hypot(np.diff(x), np.diff(y))) * MASS * g
    assert block(found, "frame_axial_force") == pytest.approx(
        [-0.75 * along[0], -0.25 * along[1]], rel=1e-6, abs=1e-9
    )
    sag = y[2] * math.cos(angle) - x[2] * math.sin(angle)
    stiffness = 207e9 * (4e-4) ** 2 / 12.0
    load = MASS * g * math.cos(angle)
    # Cantilever with load W/2 at l/2 and W/4 at the end: W/2 (l/2)^2 (3 l - l/2)/6 + W/4 l^3/3 over E I.
    wanted = load * LENGTH**3 / stiffness * (0.5 * 0.25 * 2.5 / 6.0 + 0.25 / 3.0)
    assert -sag == pytest.approx(wanted, rel=1e-3)


@pytest.mark.parametrize("release", ["none", "both"])
def test_one_element_bends_unless_both_of_its_ends_are_released(release: str) -> None:
    """Held at the pivot its end has m/2 g l; released at both ends it has no moments."""
    m = Mechanism("one", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.point("P", LENGTH, 0.0)
    m.link(
        "l",
        length=LENGTH,
        mass=MASS,
        model="elastic",
        elements=1,
        section=Section.square(4e-4),
        release=release,
    )
    if release == "both":
        m.revolute("A", "ground.O", "l.start")
        m.revolute("B", "ground.P", "l.end")
    else:
        m.weld("A", "ground.O", "l.start")
    found = started(m)
    wanted = 0.5 * MASS * 9.81 * LENGTH if release == "none" else 0.0
    assert abs(block(found, "frame_moment_1")[0]) == pytest.approx(wanted, rel=1e-5, abs=1e-9)
    assert block(found, "frame_moment_2")[0] == pytest.approx(0.0, abs=1e-6)


def test_inertia_forces_act_at_places_seen_from_the_centre() -> None:
    m = rod()
    link: Any = m.bodies["l"]
    shape, extra = straight(link), np.ones((3, 3))
    held: Any = Mechanism("held", bodies={"l": as_rigid(link, shape)})
    ((mass, places, more),) = _inertial(held, {"l": link}, {"l": shape}, {"l": extra}).values()
    assert mass == pytest.approx([0.25 * MASS, 0.5 * MASS, 0.25 * MASS]) and more is extra
    assert places == pytest.approx(np.array([[-0.3, 0.0], [0.0, 0.0], [0.3, 0.0]]), abs=1e-12)
