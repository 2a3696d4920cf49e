"""Hysteresis damping factors chi of F_N = elastic (1 + chi rate / impact_speed), as functions of the
restitution coefficient.

Their sources stand in the laws of the same names.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

from ...numerics.scalar import exp, log1p
from ..law import ContactLaw, Pair, quantity


def hertz(restitution: float) -> float:
    """0: no dissipation."""
    return 0.0


def hunt_crossley(restitution: float) -> float:
    """3/2 (1 - c_r): Hunt and Crossley 1975."""
    return 1.5 * (1.0 - restitution)


def herbert_mcwhannell(restitution: float) -> float:
    """6 (1 - c_r)/[(2 c_r - 1)^2 + 3]: Herbert and McWhannell 1977."""
    return 6.0 * (1.0 - restitution) / ((2.0 * restitution - 1.0) * (2.0 * restitution - 1.0) + 3.0)


def lee_wang(restitution: float) -> float:
    """3/4 (1 - c_r): Lee and Wang 1983."""
    return 0.75 * (1.0 - restitution)


def lankarani_nikravesh(restitution: float) -> float:
    """3/4 (1 - c_r^2): Lankarani and Nikravesh 1990."""
    return 0.75 * (1.0 - restitution * restitution)


def gonthier(restitution: float) -> float:
    """d/c_r with the authors' estimate d = 1 - c_r^2: Gonthier, McPhee, Lange and Piedboeuf 2004."""
    return (1.0 - restitution * restitution) / restitution


def gonthier_exact(restitution: float) -> float:
    """d/c_r with d from (1 + d/c_r)/(1 - d) = exp[d (1 + 1/c_r)], the relation that Gonthier's d estimates: a
    free impact gives back c_r.
    """
    low, high = 0.0, 1.0 - 4e-16  # 1 - d has a logarithm
    for _ in range(80):
        d = 0.5 * (low + high)
        too_large = log1p(d / restitution) - log1p(-d) > d * (1.0 + 1.0 / restitution)
        low, high = (low, d) if too_large else (d, high)
    return 0.0 if restitution == 1.0 else low / restitution


def zhiying_qishao(restitution: float) -> float:
    """3/4 (1 - c_r^2) exp[2 (1 - c_r)]: Zhiying and Qishao 2006."""
    return lankarani_nikravesh(restitution) * exp(2.0 * (1.0 - restitution))


def flores(restitution: float) -> float:
    """8 (1 - c_r)/(5 c_r): Flores, Machado, Silva and Martins 2011."""
    return 1.6 * (1.0 - restitution) / restitution


def hu_guo(restitution: float) -> float:
    """3 (1 - c_r)/(2 c_r): Hu and Guo 2015."""
    return 1.5 * (1.0 - restitution) / restitution


DAMPING: dict[str, Callable[[float], float]] = {
    "none": hertz,
    "hunt-crossley": hunt_crossley,
    "herbert-mcwhannell": herbert_mcwhannell,
    "lee-wang": lee_wang,
    "lankarani-nikravesh": lankarani_nikravesh,
    "gonthier": gonthier,
    "gonthier-exact": gonthier_exact,
    "zhiying-qishao": zhiying_qishao,
    "flores": flores,
    "hu-guo": hu_guo,
}
DEVIATION = (
    0.05  # of the restitution that is delivered from the one that was asked for, beyond which a law says so
)


@lru_cache(maxsize=256)
def delivered(chi: float) -> float:
    """Restitution e of a free impact with F = elastic (1 + chi rate/impact_speed): chi (1 + e) = ln[(1 +
    chi)/(1 - chi e)], by bisection.

    It follows from m v dv = -F d(delta) alone, so it holds for any mass and any elastic force.
    """
    if chi <= 0.0:
        return 1.0
    low, high = 0.0, min(1.0, (1.0 - 4e-16) / chi)
    for _ in range(80):
        e = 0.5 * (low + high)
        low, high = (e, high) if chi * (1.0 + e) > log1p(chi) - log1p(-chi * e) else (low, e)
    return low


@dataclass(frozen=True, kw_only=True)
class Damped(ContactLaw):
    """An elastic force F_e with hysteresis damping, F_N = F_e (1 + chi rate/impact_speed)."""

    restitution: float = quantity("1", "restitution coefficient c_e", 0.9, above=0.0, high=1.0)

    @property
    def hysteresis(self) -> str:
        """Name of the damping factor: that of the field ``damping`` if there is one, else the law's own."""
        return str(getattr(self, "damping", self.name))

    @property
    def damping_factor(self) -> float:
        """chi."""
        return DAMPING[self.hysteresis](self.restitution)

    def facts(self, pair: Pair) -> tuple[str, ...]:
        """Return the rebound of a free impact where the damping factor does not give the restitution of the
        model.
        """
        rebound = delivered(self.damping_factor)
        if self.hysteresis == "none" or abs(rebound - self.restitution) <= DEVIATION:
            return ()
        law_text = "" if hasattr(self, "damping") else 'the law "hertz" with '
        advice = f'{law_text}damping = "gonthier-exact" rebounds with {self.restitution:.4g}'
        factor = gonthier_exact(self.restitution) / self.damping_factor
        if factor > 1.0:
            advice += (
                f", but damps {factor:.2g} times as strongly, also when a closed contact that began"
                " slowly is struck"
            )
        return (
            (
                f"with restitution {self.restitution:.4g} a free impact rebounds with {rebound:.4g} of its"
                f" speed ({advice})"
            ),
        )
