"""A law as a table: measured force over penetration, loading and unloading."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from ...errors import Fault
from ...kernels.tabled import turned_slowness
from ...schema import Curve, FixedList, Measure, described
from ..curve import Branches, joined
from ..law import ContactLaw, Pair, quantity

POINTS = Curve(FixedList((Measure("m"), Measure("N"))), ("penetration (m)", "force (N)"))
MEET = 0.05  # of the largest force: by how much noise may have loading fall, or unloading lie above it
NOISE = 1e-3  # the same from which on it is told
Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True, kw_only=True)
class Tabulated(ContactLaw):
    """F_N = U + (L - U) s: ``loading`` L while the surfaces approach (s = 1), ``unloading`` U while they part
    (s = 0), each over the penetration.

    Points are joined by monotone cubics (Fritsch and Carlson 1980), which leave no two neighbours; of a long
    table so many are used as that takes. Where the surfaces turn, s passes from 1 to 0 in
    proportion to the rate, from ``transition`` times the impact speed to that much the other way, wherever
    the turning point is. So a contact that turns at a penetration d loses the area between the branches up to
    d, whatever its speed, but for some transition^2 of it, and since U <= L it never gains; without
    ``unloading`` it loses nothing. At rest the force is the branches' mean. Beyond its last penetration
    loading goes on along its last slope, and unloading stays as far below it.
    """

    name = "table"
    source = (
        "measured; joined after Fritsch, Carlson: Monotone piecewise cubic interpolation. SIAM Journal on"
        " Numerical Analysis 17 (1980) 238-246"
    )
    formula = "F = U(d) + (L(d) - U(d)) (1 + x)/2, x = d'/(transition d'0) within -1 and 1"
    slots = ("inverse_transition",)
    slot_units: ClassVar[dict[str, str]] = {"inverse_transition": "1"}
    tabled = True

    loading: Points = described(
        POINTS,
        "penetration and force of each point while the surfaces approach, ascending; in a file also a CSV"
        " file",
    )
    unloading: Points | None = described(
        POINTS, "the same while they part, nowhere above loading; left out: the loading curve again", None
    )
    force_factor: float = quantity("1", "factor of all forces", 1.0, above=0.0)
    penetration_factor: float = quantity("1", "factor of all penetrations", 1.0, above=0.0)
    transition: float = quantity(
        "1",
        "share of the impact speed below which the force is between the branches, in proportion to the rate",
        0.05,
        low=1e-3,
        high=1.0,
    )

    def disagreements(self) -> Iterator[Fault]:
        """Curves that are none, and an unloading one that would give energy."""
        result = list(faults_of_points("loading", self.loading))
        result += faults_of_points("unloading", self.unloading) if self.unloading is not None else ()
        yield from result or faults_of_both(self.loading, self.unloading)

    @property
    def branches(self) -> Branches:
        """The curves as pieces, without the factors."""
        return joined(self.loading, self.unloading)

    @property
    def pieces(self) -> tuple[tuple[float, ...], ...]:
        """Where each piece begins (m), the coefficients of the branches' mean and of half their distance,
        constant first.
        """
        return self.branches.scaled(self.penetration_factor, self.force_factor)

    @property
    def end(self) -> float:
        """The last penetration (m) of the table."""
        return self.penetration_factor * self.branches.end

    def knots(self) -> tuple[tuple[float, ...], ...]:
        """Return the pieces of the curve."""
        return self.pieces

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """1/transition (1), then the pieces one after the other."""
        return (1.0 / self.transition, *(value for piece in self.pieces for value in piece))

    def derived(self, pair: Pair) -> dict[str, str]:
        """Return the slot that the fields do not show."""
        return {"inverse_transition": f"{1.0 / self.transition:.6g}"}

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N), the mean of the branches, and damping coefficient (N s/m), half their distance
        over the rate of ``slowness``.
        """
        piece = _piece(p, penetration)
        x = penetration - piece[0]
        _, m0, m1, m2, m3, h0, h1, h2, h3 = piece
        return m0 + x * (m1 + x * (m2 + x * m3)), slowness * (h0 + x * (h1 + x * (h2 + x * h3)))

    def slowness(self, speed: float, rate: float) -> float:
        """1/|rate| (s/m), at most that of the transition."""
        result: float = turned_slowness(1.0 / speed, 1.0 / self.transition, rate)
        return result

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """Energy (J) of the branches' mean: what is stored, where nothing is lost yet."""
        import numpy as np

        depth = np.maximum(np.asarray(penetration, dtype=float), 0.0)
        rows = np.array(p[1:]).reshape(-1, 9)
        powers = 1.0 / np.arange(1.0, 5.0)

        def work(k: Any, x: Any) -> Any:
            c = rows[k, 1:5] * powers
            return x * (c[..., 0] + x * (c[..., 1] + x * (c[..., 2] + x * c[..., 3])))

        starts = rows[:, 0]
        total = np.concatenate([[0.0], np.cumsum(work(np.arange(len(rows) - 1), np.diff(starts)))])
        at = np.maximum(np.searchsorted(starts, depth, side="right") - 1, 0)
        return total[at] + work(at, depth - starts[at])

    def cautions(
        self, pair: Pair, penetration: float | None = None, impact_speed: float | None = None
    ) -> tuple[str, ...]:
        """Return notes on the reduction of a long or noisy table, and on penetrations beyond the table."""
        result, curve = [], self.branches
        if curve.used < curve.available:
            missed = f"{100.0 * curve.missed:.2g} % of the largest force"
            result.append(
                f"{curve.used} of {curve.available} penetrations are used, the curve through which misses the"
                f" others by up to {missed}"
            )
        if curve.levelled > NOISE:
            moved = f"points were moved by up to {100.0 * curve.levelled:.2g} % of the largest force"
            result.append(f"{moved}, so that loading does not fall and unloading is not above it")
        if penetration is not None and penetration > self.end:
            deep = (
                f"penetrations of up to {penetration:.4g} m are beyond the table, which ends at"
                f" {self.end:.4g} m"
            )
            result.append(f"{deep}: it goes on there along its last slope")
        return tuple(result)


def _piece(p: tuple[float, ...], penetration: float) -> tuple[float, ...]:
    """Select the piece for a penetration from a flat tuple of parameters."""
    count = len(p) // 9
    at = 0
    for k in range(1, count):
        at = k if penetration >= p[1 + 9 * k] else at
    return p[1 + 9 * at : 10 + 9 * at]


def faults_of_points(name: str, points: Points) -> Iterator[Fault]:
    """Yield the faults of one measured curve."""
    if len(points) < 2:
        yield Fault(
            name, f"a table of {len(points)} points", "", "two points or more", "add points of the curve"
        )
        return
    for (previous, _), (place, _) in zip(points, points[1:], strict=False):
        if not place > previous:
            yield Fault(
                name,
                f"the penetration {place:g} m does not come after {previous:g} m",
                "",
                "ascending penetrations",
                "sort the points",
            )
            return
    first, force = points[0]
    if first < 0.0 or (force != 0.0 and first == 0.0):
        problem = (
            f"it begins before the surfaces touch, at {first:g} m"
            if first < 0.0
            else f"it begins with {force:g} N at no penetration"
        )
        yield Fault(name, problem, "", "0 N at 0 m", "take the offset off the measured values")
    elif min(force for _, force in points) < 0.0:
        yield Fault(
            name,
            "a force below 0 N",
            "",
            "surfaces that push",
            "take the offset off the measured values, or leave such points out",
        )
    elif max(force for _, force in points) == 0.0:
        yield Fault(name, "no force anywhere", "", "a force above 0 N", "check the columns")


def faults_of_both(loading: Points, unloading: Points | None) -> Iterator[Fault]:
    """Yield the fault of a falling loading curve, or of unloading above loading, by more than noise."""
    result = joined(loading, unloading).levelled
    if result > MEET:
        crossed = joined(loading, None).levelled <= MEET
        problem = (
            "it is above loading, where a contact would give energy"
            if crossed
            else "its force falls while the surfaces approach"
        )
        remedy = (
            "check which curve is which, and that both are of one specimen"
            if crossed
            else "smooth the curve, or fit a law to it (vfife fit)"
        )
        yield Fault(
            "unloading" if crossed else "loading",
            f"{problem}, by {100.0 * result:.3g} % of the largest",
            "",
            f"{100.0 * MEET:g} %",
            remedy,
        )
