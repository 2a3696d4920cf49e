"""Long runs: memory stays flat, the ledger closes, the journal never leaves."""

import math
import resource
from pathlib import Path

import pytest

import vfife

CASE_C = Path(__file__).parents[2] / "examples" / "four_bar_case_c.toml"


def peak() -> int:
    """Largest resident memory so far (kB)."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


@pytest.mark.soak
@pytest.mark.parametrize("loop", ["data-driven", "generated"])
def test_five_hundred_turns(loop: str) -> None:
    """Ten million steps with as many outputs as a short run keep the memory of the short run."""
    vfife.simulate(vfife.load_model(CASE_C), turns=5, step=2e-6, outputs=400, loop=loop)
    before = peak()
    result = vfife.simulate(vfife.load_model(CASE_C), turns=500, step=2e-6, outputs=4, loop=loop)
    assert result.record.status == "complete"
    assert peak() - before < 20_000
    assert result.ledger.error < 1e-4
    assert result.measures["C.penetration.max"] < 0.5e-3


@pytest.mark.soak
def test_a_thousand_million_steps() -> None:
    """A mass on a spring: outputs are counted and timed exactly, memory stays that of a short run, and the
    last place is that of the equation.

    Central differences of x'' = -w^2 x from rest have x_n = x_0 cos(n phi), cos(phi) = 1 - (w dt)^2/2.
    """
    m = vfife.Mechanism("mass on a spring")
    m.point("O", 0.0, 0.0)
    m.point_mass("ball", mass=1.0, position=(1.0, 0.0), velocity=(0.0, 0.5, 0.0))
    m.spring("s", "ground.O", "ball.center", stiffness=100.0, free_length=0.0)
    step, count, outputs = 1e-3, 10**9, 1000

    def run(steps: int) -> vfife.Result:
        return vfife.simulate(m, step=step, duration=steps * step, outputs=outputs, reference=False)

    run(10**6)
    before = peak()
    result = run(count)
    record = result.record
    assert record.status == "complete"
    assert record.steps.tolist() == [k * (count // outputs) for k in range(outputs + 1)]
    assert result.time.tolist() == [n * record.assembly.choice.step for n in record.steps.tolist()]
    assert record.assembly.choice.step == step
    assert peak() - before < 5_000
    assert result.ledger.error == pytest.approx(
        (0.5 * step * 10.0) ** 2, rel=1e-3
    )  # what one step leaves open, and no more
    phi = 2.0 * math.asin(0.5 * step * 10.0)
    assert record.block("particle_x")[-1].max() == pytest.approx(
        math.cos(math.fmod(count * phi, 2.0 * math.pi)), abs=1e-6
    )
