"""Searches of a fit: the first points, which of them are begun from, and the way down from each, side by side."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...errors import VfifeError
from ..sampling import sobol
from .asking import Together
from .concluded import Ended
from .confidence import WEAK, autocorrelation
from .evaluations import Evaluations, Look, Seen
from .jacobians import Slopes, compared
from .misfit import Fitted

Array = NDArray[np.float64]
Ask = Callable[[list[Look]], list[Seen]]
Derivatives = Literal["auto", "tangents", "differences"]
APART = 0.05  # of the diagonal of the bounds: how far apart starts lie
CLOSE = 1e-6  # relative change of cost and of the parameters at which a search ends
PATIENT, HOPELESS = 8, 30.0  # evaluations after which a search is left whose cost is so many times the best
ROUNDS = 40  # evaluations of one local search, at the most
AGAIN = 3  # times that searches are begun from other points, at the most
LITTLE, FOLLOWS = 0.01, 0.2  # of the deviation: what is left and need not be noise; correlation of residuals from which on they are no noise
SHARPER = 5.0  # times: what is known so much better than the rest stays, where more points are looked for
AT_ONCE = 16  # first points, so that progress is seen, and lanes are full


class Hopeless(Exception):
    """A search that leads nowhere beside another."""


@dataclass
class Descents:
    """Searches under way. What one of them sees of the others is the best point when its answer came, which is the same whoever is quicker."""

    looked: Evaluations
    ended: Ended
    derivatives: Derivatives

    def run(self, screened: int, starts: int, seed: int) -> None:
        """All of them; again from other points as long as what the best one leaves is no noise."""
        sought = self.looked.sought
        places = sobol(screened, len(sought), seed)
        if all(one.here is not None for one in sought):
            own = [one.share(one.here) for one in sought if one.here is not None]
            places = np.concatenate([[own], places[: max(screened - 1, 0)]])
        chosen = self.chosen(self.screen(places), starts, [])
        self.choose_derivatives(*chosen[0])
        self.descend_together(chosen)
        for again in range(1, AGAIN + 1):
            if not self.unexplained or self.looked.best is None:
                return
            best = self.looked.best[1]
            found = self.screen(self.further(max(screened // 2, starts), seed + again))
            self.descend_together(self.chosen(found, starts, [best]))

    @property
    def unexplained(self) -> bool:
        """Whether the best point leaves more than noise: residuals that follow one another, as they do where a search ended in a wrong place."""
        misfit, best = self.looked.misfit, self.looked.best
        if best is None or best[2].fitted is None or misfit.how != "curve" or self.looked.share < LITTLE:
            return False
        parts = misfit.columns(best[2].fitted.residuals).T
        return autocorrelation(list(parts)) > FOLLOWS + 2.0 / math.sqrt(parts.shape[1])

    def further(self, count: int, seed: int) -> Array:
        """Points anew. What the best one knows much more sharply than the rest, as the speed of a drive, stays as it is: beside another speed all
        curves are out of step, and look alike.
        """
        _, shares, seen = self.looked.best or (0.0, np.zeros(0), Seen(None))
        slopes = self.looked.slopes(Look(tuple(shares), None, self.ended.tangents), seen)
        _, sizes, rows = np.linalg.svd(slopes.jacobian, full_matrices=False)
        spread = np.sqrt(((rows.T / np.maximum(sizes, WEAK * sizes[0])) ** 2).sum(axis=1)) if sizes[0] > 0.0 else np.ones(len(shares))
        open_ = np.flatnonzero(spread >= spread.max() / SHARPER)
        places = np.tile(shares, (count, 1))
        places[:, open_] = sobol(count, len(open_), seed)
        return places

    def screen(self, places: Array) -> list[tuple[Array, Fitted]]:
        """Points with their curves, the best first. Raises VfifeError where none has a motion."""
        found: list[tuple[Array, Fitted]] = []
        for first in range(0, len(places), AT_ONCE):
            some = places[first : first + AT_ONCE]
            seen = self.looked([Look(tuple(one)) for one in some])
            found += [(at, one.fitted) for at, one in zip(some, seen, strict=True) if one.fitted is not None]
        if not found:
            raise VfifeError(f"none of {len(places)} members has a motion: {self.looked.reasons[0]}; correct the bounds")
        return sorted(found, key=lambda one: one[1].cost)

    def chosen(self, found: list[tuple[Array, Fitted]], starts: int, known: list[Array]) -> list[tuple[Array, Fitted]]:
        """The best points that are far enough from each other and from those that are ``known``."""
        chosen: list[tuple[Array, Fitted]] = []
        for at, one in found:
            there = [*known, *(other for other, _ in chosen)]
            if len(chosen) < starts and all(np.linalg.norm(at - other) > APART * math.sqrt(len(at)) for other in there):
                chosen.append((at, one))
        return chosen

    def descend_together(self, chosen: list[tuple[Array, Fitted]]) -> None:
        """Searches from several points, side by side."""
        Together(self.looked).run([lambda ask, at=at: self.descend(ask, *at) for at in chosen])  # type: ignore[misc]

    def choose_derivatives(self, shares: Array, one: Fitted) -> None:
        """Tangents where differences of runs say the same; where they do not, an end of a contact or a far neighbour decides, and a tangent
        of one run leads nowhere.
        """
        if self.derivatives == "differences":
            return
        at = tuple(shares)
        seen = Seen(one)
        try:
            by_steps = self.looked.slopes(Look(at, one.offset, True), seen)
        except VfifeError as error:
            if self.derivatives == "tangents":
                raise
            self.ended.notes.append(f"no derivatives were carried along: {' '.join(str(error).split())}")
            return
        self.ended.tangents = self.derivatives == "tangents" or compared(by_steps, self.looked.slopes(Look(at, one.offset, False), seen))

    def descend(self, ask: Ask, start: Array, first: Fitted) -> None:
        """One search from a start. A member and what its derivatives need are asked for at once: lanes have room for them."""
        from scipy.optimize import least_squares

        near, count, misfit = first.offset, 0, self.looked.misfit
        met: dict[bytes, tuple[Array, Slopes | None]] = {}

        def at(shares: Array) -> tuple[Array, Slopes | None]:
            nonlocal near, count
            if (key := shares.tobytes()) not in met:
                (seen,) = ask([Look(tuple(shares), near, self.ended.tangents)])
                if seen.fitted is None:
                    met[key] = misfit.lost, None
                else:
                    near, count = seen.fitted.offset, count + 1
                    met[key] = seen.fitted.residuals, seen.slopes
                    if count > PATIENT and self.looked.best is not None and seen.fitted.cost > HOPELESS * self.looked.best[0]:
                        raise Hopeless
            return met[key]

        def jacobian(shares: Array) -> Array:
            slopes = at(shares)[1]
            return slopes.jacobian if slopes is not None else np.zeros((misfit.count, len(shares)))

        inside, tight = np.clip(start, 1e-6, 1.0 - 1e-6), {"ftol": CLOSE, "xtol": CLOSE, "gtol": 1e-12, "max_nfev": ROUNDS}
        try:
            found: Any = least_squares(lambda shares: at(shares)[0], inside, jacobian, (0.0, 1.0), "trf", **tight)
        except Hopeless:
            return
        values = (float(one.value(x)) for one, x in zip(self.looked.sought, found.x, strict=True))
        self.ended.searches.append((float(found.cost), tuple(values)))
