"""Gauss' rule against exact integrals of powers and NumPy's."""

import numpy as np
import pytest

from vfife.numerics.quadrature import gauss


@pytest.mark.parametrize("count", [1, 2, 3, 7, 20, 61])
def test_powers_are_integrated_exactly(count: int) -> None:
    nodes, weights = (np.array(one) for one in gauss(count))
    for degree in range(0, 2 * count, max(1, count // 5)):
        assert (weights * nodes**degree).sum() == pytest.approx(
            2.0 / (degree + 1.0) if degree % 2 == 0 else 0.0, abs=3e-15
        )
    known = np.polynomial.legendre.leggauss(count)
    assert np.allclose(nodes, known[0], rtol=0.0, atol=1e-15) and np.allclose(weights, known[1], rtol=1e-13)
