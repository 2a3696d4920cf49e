"""A lubricated journal: the short bearing's oil film, which also acts while the surfaces are apart, and
Hertz' contact where it is thin.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from ...numerics import elementwise
from ...numerics.scalar import integer_power
from ..law import ContactLaw, Pair, quantity
from .damping import lankarani_nikravesh


@dataclass(frozen=True, kw_only=True)
class Hydrodynamic(ContactLaw):
    """F_N = film's radial force + film's damping * rate + K delta^1.5 [1 + 3 (1 - c_e^2)/4 *
    rate/impact_speed].

    Ocvirk's short bearing with the half-Sommerfeld (Guembel) condition, pressure on the half of the film that
    the surfaces run into. With eps = e/c, A = mu R L^3/(2 c^2) and the entrainment w = w_J + w_B - 2 gamma'
    (gamma the direction of the line of centres), on the journal

        towards the bearing's centre   A [2 |w| eps^2/(1 - eps^2)^2 + pi (1 + 2 eps^2)/(1 - eps^2)^(5/2) eps']
        across, along t                A [pi w eps/(2 (1 - eps^2)^(3/2)) + 4 sgn(w) eps eps'/(1 - eps^2)^2]

    The film never pulls. Where it is thinner than ``film_thickness`` it stays as it is there, and fades out
    linearly over as much of penetration while the surfaces bear on one another, so the force is continuous
    (the transition of Flores et al., simplified).

    Departures: the film's half is that of the entrainment whatever the squeeze is, so pure squeeze meets half
    of the whole film's damping; the force acts at the centres, and the moments of shear on the two bodies
    (Petroff) are left out: what turns the shaft feeds the film, and the energy ledger counts that as a loss
    of either sign. Friction of the surfaces acts on the dry part of the force alone, and without arms.
    """

    name = "hydrodynamic"
    source = (
        "Dubois, Ocvirk: Analytical derivation and experimental evaluation of short-bearing approximation for"
        " full journal bearings. NACA Report 1157 (1953); transition to dry contact after Flores, Ambrosio,"
        " Claro, Lankarani, Koshy: Lubricated revolute joints in rigid multibody systems. Nonlinear Dynamics"
        " 56 (2009) 277-295"
    )
    formula = (
        "F = A (2 |w| s^2/(1 - s^2)^2 + pi (1 + 2 s^2)/(1 - s^2)^2.5 s') + K d^1.5 (1 + 3/4 (1 - e^2)"
        " d'/d'0), A = mu R L^3/(2 c^2)"
    )
    slots = ("stiffness", "damping_factor", "film_scale", "clearance", "film_thickness")
    slot_units: ClassVar[dict[str, str]] = {"film_scale": "N s", "clearance": "m"}
    film = True

    viscosity: float = quantity("Pa s", "dynamic viscosity of the lubricant", 0.05, above=0.0)
    film_thickness: float | None = quantity(
        "m", "film at which the surfaces begin to bear; clearance/50 if left out", None, above=0.0
    )
    restitution: float = quantity(
        "1", "restitution coefficient c_e of the dry contact", 0.9, above=0.0, high=1.0
    )
    stiffness: float | None = quantity(
        "N/m^1.5", "generalised stiffness K; from radii and materials if left out", None, above=0.0
    )

    def parameters(self, pair: Pair) -> tuple[float, ...]:
        """Stiffness (N/m^1.5), damping factor (1), A (N s), clearance and least film (m). Raises ValueError
        outside a bearing.
        """
        self.require_inside(pair)
        stiffness = pair.hertz_stiffness if self.stiffness is None else self.stiffness
        scale = (
            self.viscosity
            * pair.journal_radius
            * integer_power(pair.axial_length, 3)
            / (2.0 * (pair.clearance * pair.clearance))
        )
        thickness = self.film_thickness if self.film_thickness is not None else pair.clearance / 50.0
        return float(stiffness), lankarani_nikravesh(self.restitution), scale, pair.clearance, thickness

    @staticmethod
    def force(penetration: float, slowness: float, p: tuple[float, ...]) -> tuple[float, float]:
        """Elastic force (N) and damping coefficient (N s/m) of the dry contact."""
        stiffness, damping_factor, _, _, _ = p
        elastic = stiffness * penetration * math.sqrt(penetration)
        return elastic, elastic * damping_factor * slowness

    @staticmethod
    def film_force(
        penetration: float, turning: float, sense: float, p: tuple[float, ...]
    ) -> tuple[float, float, float, float, float]:
        """Return the radial force and the force across (N) at rest, and the damping coefficients D_n, D_t and
        X (N s/m) of the film.

        Towards the bearing's centre it exerts radial + D_n v_n - X v_t, along t on the journal across + X v_n
        - D_t v_t, with the velocity (v_n, v_t) of the journal's centre relative to the bearing's (m/s).

        penetration: of the dry surfaces, negative while they are apart (m)
        turning: e (w_J + w_B) (m/s), so that nothing is divided by e
        sense: sign of w
        p: the parameters of :meth:`parameters`
        """
        _, _, scale, clearance, thickness = p
        fade = 1.0 - penetration / thickness
        fade = 1.0 if fade > 1.0 else fade
        fade = 0.0 if fade < 0.0 else fade
        gap = -penetration if -penetration > thickness else thickness
        eps = 1.0 - gap / clearance
        eps = eps if eps > 0.0 else 0.0
        inner = (1.0 - eps) * (1.0 + eps)
        root = math.sqrt(inner)
        square = inner * inner
        amount = fade * scale / clearance
        cross = 4.0 * amount * sense * eps / square
        tangential = amount * math.pi / (inner * root)
        damping = amount * math.pi * (1.0 + 2.0 * eps * eps) / (square * root)
        return 0.5 * cross * turning, 0.5 * tangential * turning, damping, tangential, cross

    def elastic_energy(self, penetration: Any, p: tuple[float, ...]) -> Any:
        """2/5 K delta^2.5 (J), of the dry contact."""
        return 0.4 * p[0] * (penetration * penetration * elementwise.sqrt(penetration))
