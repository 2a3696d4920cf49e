"""The four-bar of Akhadkar, Acary and Brogliato (2016) with three loose joints, beside Siconos' numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

import vfife
from vfife import Mechanism, gallery
from vfife.drivers import AngleTable
from vfife.modelfile.parameter import with_values
from vfife.report.document import Table
from vfife.simulation.result import Result

from ..paper.contents import Chart, Item, Line, Panel, Parameter, Verdict

Array = NDArray[np.float64]
REFERENCE = Path(__file__).with_name("four_bar_loose.csv")
JOINTS = ("B", "C", "D")
CLEARANCE = 5e-3  # m
TOUCHING = 1e-6  # m, tolerance of the gaps there
ANGLE = 20.0  # degrees
SHAKEN = 12.0  # rad/s^2, of the crank's acceleration beside the slope of its rates
LEAD = 0.0125  # s, between the angles of a crank that is led through rates too
VARIANTS: dict[str, tuple[str, tuple[float, ...], str]] = {
    "friction": ("joint.B.friction.coefficient", (0.0, 0.2), ""),
    "restitution, which is 0 there": ("joint.B.contact.restitution", (0.3, 0.6), ""),
    "clearance": ("joint.B.clearance", (2.5e-3, 10e-3), "m"),
    "stiffness, 1.23e11 N/m^1.5; joints are rigid there": ("joint.B.contact.stiffness", (1.2e10,), "N/m^1.5"),
}


class Chain(NamedTuple):
    """A motion at times (s): angles (rad) of coupler and rocker, journals (m) seen from their bearings,
    contact forces (N) by joint, torque (N m) on the crank.
    """

    times: Array
    angles: Array  # (times, 2)
    journals: Array  # (times, 3, 2)
    forces: Array  # (times, 3)
    torque: Array

    def at(self, times: Array) -> Chain:
        """Return the outputs nearest to some times."""
        places = np.abs(self.times[:, None] - times).argmin(axis=0)
        return Chain(*(values[places] for values in self))

    @property
    def directions(self) -> Array:
        """Directions (degrees) of the journals, shape (times, 3)."""
        return np.degrees(np.arctan2(self.journals[..., 1], self.journals[..., 0]))


class Crank(NamedTuple):
    """The crank in the reference file: times (s), angles (rad), rates (rad/s), and accelerations (rad/s^2),
    by Newton's law from torque and contact force, and as slopes of the rates.
    """

    times: Array
    angles: Array
    rates: Array
    accelerations: Array
    slopes: Array

    @property
    def smooth(self) -> NDArray[np.bool_]:
        """Whether both accelerations agree at a time: elsewhere a transient of a contact shakes the crank."""
        return np.abs(self.accelerations - self.slopes) < SHAKEN


def crank() -> Crank:
    """Read the motion of the crank."""
    from scipy.interpolate import CubicSpline

    rows = np.genfromtxt(REFERENCE, delimiter=",", comments="#", skip_header=6)
    times, (angles, rates, accelerations) = rows[:, 0], rows[:, 13:16].T
    return Crank(times, angles, rates, accelerations, CubicSpline(times, rates).derivative()(times))


def led_through_rates(m: Mechanism) -> Mechanism:
    """Lead the crank through the rates of the file too, by pieces of fifth degree between its times."""
    from scipy.interpolate import BPoly

    theirs, driver = crank(), cast(AngleTable, m.drivers["crank"])
    course = BPoly.from_derivatives(
        theirs.times, np.stack([theirs.angles, theirs.rates, theirs.slopes], axis=1)
    )
    early = [
        (time, value)
        for time, value in zip(driver.times, driver.values, strict=True)
        if time < theirs.times[0]
    ]
    count = round((theirs.times[-1] - theirs.times[0]) / LEAD)
    late = np.linspace(theirs.times[0], theirs.times[-1], count + 1)
    angles = course(late) - m.bodies["crank"].angle
    times, values = zip(*early, *zip(late.tolist(), angles.tolist(), strict=True), strict=True)
    m.drivers["crank"] = replace(driver, times=times, values=values)
    return m


def reference() -> Chain:
    """Read the 20 times of the reference file after its start."""
    rows = np.genfromtxt(REFERENCE, delimiter=",", comments="#", skip_header=6)
    journals = 1e-3 * rows[:, 3:9].reshape(-1, 3, 2)
    return Chain(rows[:, 0], rows[:, 1:3], journals, rows[:, 9:12], rows[:, 12])


def chain_of(result: Result, loose: bool = True) -> Chain:
    """Return the series of a run; journals and contact forces of a run with loose joints."""
    series = result.series

    def stack(kind: str, names: tuple[str, ...] = JOINTS) -> Array:
        return np.stack([np.asarray(series[f"{name}.{kind}"]) for name in names], axis=-1)

    angles = stack("angle", ("coupler", "rocker"))
    blank = np.zeros((len(angles), 3))
    journals = [stack(f"eccentricity_{axis}") if loose else blank for axis in "xy"]
    forces = stack("normal_force") if loose else blank
    torque = np.asarray(series["crank.torque"])
    return Chain(np.asarray(result.time), angles, np.stack(journals, axis=-1), forces, torque)


def simulate(changes: Mapping[str, float] | None = None, ideal: bool = False, rates: bool = False) -> Chain:
    """Run the model, with numbers of joint B and their like in C and D, with ideal joints, or with a crank
    that is led through the ``rates`` of the file too.
    """
    values = {
        path.replace(".B.", f".{name}."): value for path, value in (changes or {}).items() for name in JOINTS
    }
    model = with_values(gallery.four_bar_loose(), values)
    model = led_through_rates(model) if rates else model
    if ideal:
        model = model.ideal()
    return chain_of(vfife.simulate(model, companions=0), not ideal)


def direction_error(chain: Chain, reference_chain: Chain) -> Array:
    """Return the differences (degrees) of the directions of the journals, shape (times, 3)."""
    return np.asarray(np.abs((chain.directions - reference_chain.directions + 180.0) % 360.0 - 180.0))


def deviations(ours: Chain, theirs: Chain) -> tuple[float, float, float]:
    """Return the medians of the difference of directions (degrees), and of contact forces (1), and the
    largest difference of angles (rad).
    """
    forces = np.abs(ours.forces - theirs.forces).mean() / theirs.forces.mean()
    angles = np.abs(ours.angles - theirs.angles).max()
    return float(np.median(direction_error(ours, theirs))), float(forces), float(angles)


def shares(ours: Chain, theirs: Chain, times: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the mean differences of contact forces and of the torque over their means, at some times."""
    force = np.abs(ours.forces - theirs.forces)[times].mean() / theirs.forces[times].mean()
    torque = np.abs(ours.torque - theirs.torque)[times].mean() / np.abs(theirs.torque[times]).mean()
    return float(force), float(torque)


def smooth_verdicts(ours: Chain, led: Chain, theirs: Chain) -> list[Verdict]:
    """Judge forces and torque where no transient shakes their crank; ``led`` through its rates too."""
    crank_motion = crank()
    gap, smooth = np.abs(crank_motion.accelerations - crank_motion.slopes), crank_motion.smooth
    shares_of_ours, shares_of_led = shares(ours, theirs, smooth), shares(led, theirs, smooth)
    torque = np.abs(ours.torque - theirs.torque)
    share = 100.0 * torque[~smooth].sum() / torque.sum()
    shaken = f"at {', '.join(f'{time:.2f}' for time in crank_motion.times[~smooth])} s"
    return [
        Verdict(
            "the crank of the reference file moves smoothly, as ours does", bool(smooth.all()),
            f"{shaken} its acceleration by Newton's law is"
            f" {gap[~smooth].min():.0f} to {gap.max():.0f} rad/s²"
            f" beside the slope of its rates, elsewhere {gap[smooth].max():.1f} or less; these"
            f" {int((~smooth).sum())} of {len(gap)} times hold {share:.0f} %"
            " of all differences of the torque",
        ),
        Verdict(
            "where it does, and led through its rates too, contact forces agree within 10 %",
            shares_of_led[0] < 0.1,
            f"{100 * shares_of_led[0]:.1f} % ({100 * shares_of_ours[0]:.0f} % led through angles alone)",
        ),
        Verdict(
            "where it does, and led through its rates too, the torque agrees within 10 %",
            shares_of_led[1] < 0.1,
            f"{100 * shares_of_led[1]:.1f} % ({100 * shares_of_ours[1]:.0f} % led through angles alone)",
        ),
    ]  # fmt: skip


def verdicts(ours: Chain, theirs: Chain, ideal: Chain) -> list[Verdict]:
    """Judge the motion against the reference file at its times."""
    direction, force, angle = deviations(ours, theirs)
    ideal_angle = float(np.abs(ideal.angles - theirs.angles).max())
    close_count = int((direction_error(ours, theirs) <= ANGLE).sum())
    touching, ours_touching = (
        (np.hypot(*np.moveaxis(chain.journals, -1, 0)) > CLEARANCE - TOUCHING) & (chain.forces > 0.0)
        for chain in (theirs, ours)
    )
    torque = shares(ours, theirs, np.ones(len(theirs.times), dtype=np.bool_))[1]
    return [
        Verdict(
            "coupler and rocker have the angles of the reference file within 0.002 rad",
            angle < 2e-3,
            f"{1e3 * angle:.2g} mrad apart at most, without clearance {1e3 * ideal_angle:.2g} mrad",
        ),
        Verdict(
            "joints lose contact seldom: at 1 of 60 outputs, joint C at 0.5 s",
            bool(not ours_touching[~touching].any() and (~ours_touching).sum() <= 3),
            f"here at {int((~ours_touching).sum())} of {ours_touching.size}, the same one among them",
        ),
        Verdict(
            f"journals lie where those of the reference file do, within {ANGLE:.0f}° in 9 of 10 cases",
            close_count >= 0.9 * ours_touching.size,
            f"in {close_count} of {ours_touching.size}; {direction:.2g}° apart in the median",
        ),
        Verdict(
            "contact forces are those of the reference file within 10 %", force < 0.1,
            f"mean difference {100 * force:.0f} % of the mean force, {theirs.forces.mean():.3g} N there and"
            f" {ours.forces.mean():.3g} N here",
        ),
        Verdict(
            "the torque on the crank is that of the controller within 10 %", torque < 0.1,
            f"mean difference {100 * torque:.0f} % of its mean size, {np.abs(theirs.torque).mean():.3g} N m",
        ),
    ]  # fmt: skip


def influence(ours: Chain, theirs: Chain) -> Table:
    """Tabulate how near the motion comes with other numbers."""
    cases = [("as in the model file", "", ours)]
    for name, (path, values, unit) in VARIANTS.items():
        cases += [
            (name, f"{value:g} {unit}".strip(), simulate({path: value}).at(theirs.times)) for value in values
        ]
    rows = []
    for name, value, chain in cases:
        direction, force, angle = deviations(chain, theirs)
        rows.append((name, value, f"{direction:.1f}°", f"{100.0 * force:.0f} %", f"{1e3 * angle:.2f} mrad"))
    return Table(
        ("number", "value", "directions (median)", "forces (mean)", "angles (most)"),
        rows,
        title="Differences from the reference file",
        numbers=(2, 3, 4),
    )


def chart(ours: Chain, theirs: Chain) -> Chart:
    """Draw contact force and direction of joint B, and the torque."""
    wrapped = np.unwrap(ours.directions[:, 0], period=360.0)
    nearest = np.interp(theirs.times, ours.times, wrapped)
    dots = theirs.directions[:, 0] + 360.0 * np.round((nearest - theirs.directions[:, 0]) / 360.0)
    late = ours.times > 0.02
    shown = [
        ("contact force of joint B", "force (N)", ours.forces[:, 0], theirs.forces[:, 0]),
        ("place of journal B in its bearing", "direction (°)", wrapped, dots),
        ("torque on the crank", "torque (N m)", ours.torque, theirs.torque),
    ]
    return Chart(
        "published_chain", "Joint B and the crank of the four-bar with three loose joints",
        [
            Panel(title, "time (s)", unit, [
                Line(ours.times[late], values[late], "vfife"),
                Line(theirs.times, marks, "Siconos", "paper", True),
            ])
            for title, unit, values, marks in shown
        ], 3,
    )  # fmt: skip


def item() -> Item:
    """Report the motion of one second beside the reference file of Siconos."""
    motion, theirs = simulate(), reference()
    ours, ideal, led = (
        chain.at(theirs.times) for chain in (motion, simulate(ideal=True), simulate(rates=True))
    )
    text = (
        "Akhadkar, Acary, Brogliato: Multibody System Dynamics 38 (2016) 101-136, doi"
        " 10.1007/s11044-016-9523-x. We could read the abstract, but not figures and tables. Numbers and"
        " one motion are from the example FourBarLinkageWith3clearance of Siconos (siconos-tutorials).",
        "There a controller moves the crank. Here a driver moves it through the same 21 angles, so coupler,"
        " rocker, journals and forces are compared, and the torque that this motion needs. After a contact is"
        " lost and closes again, their crank, which a controller holds softly, is shaken; ours is not. The"
        " file's own torque and contact force show when.",
    )
    parameters = [
        Parameter("lengths, masses, clearance 5 mm", "as in the model file", "stated", "by Siconos"),
        Parameter("friction 0.1", "coulomb", "stated", "by Siconos"),
        Parameter("restitution 0", "0.02, hertz with gonthier-exact", "chosen", "the law needs more than 0"),
        Parameter("joints", "steel, 20 mm wide", "chosen", "contacts are rigid there"),
        Parameter("crank", "21 angles of the file", "inferred", "between them the law of the controller"),
    ]
    direction, force, angle = deviations(ours, theirs)
    return Item(
        "loose-chain", "Akhadkar, Acary, Brogliato 2016: a four-bar with three loose joints", text,
        parameters,
        [chart(motion, theirs)], [influence(ours, theirs)],
        [*verdicts(ours, theirs, ideal), *smooth_verdicts(ours, led, theirs)],
        {"direction_deg": direction, "force": force, "angle_rad": angle},
    )  # fmt: skip
