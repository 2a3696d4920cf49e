"""The local influence parameter: by how much clearance raises a maximum above that of the ideal mechanism."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

NEGLIGIBLE = 1e-6  # an ideal maximum this small beside the largest of its kind is round-off or nothing, and no share of it says anything


def lip(largest: float, ideal: float) -> float:
    """(max - ideal max)/ideal max * 100, in per cent: Eq. 38 for forces, Eq. 39 for accelerations."""
    return (largest - ideal) / ideal * 100.0


def influence(own: Mapping[str, float], ideal: Mapping[str, float], driven: Iterable[str] = ()) -> dict[str, float]:
    """``<joint>.force.lip`` and ``<body>.angular_acceleration.lip`` (per cent) for what both mechanisms have.

    Driven bodies are left out, their motion is prescribed; so is what does not move or carry anything in the ideal
    mechanism.
    """
    prescribed = set(driven)
    found = {}
    for kind in ("force", "angular_acceleration"):
        ending = f".{kind}.max"
        names = [key.removesuffix(ending) for key in own if key.endswith(ending) and key in ideal]
        floor = NEGLIGIBLE * max((ideal[name + ending] for name in names), default=0.0)
        for name in names:
            if name not in prescribed and ideal[name + ending] > floor:
                found[f"{name}.{kind}.lip"] = lip(own[name + ending], ideal[name + ending])
    return found
