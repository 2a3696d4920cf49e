"""Products and decompositions against what they have to satisfy, NumPy's, and the same text as
plain Python.
"""

from __future__ import annotations

import numpy as np
import pytest

from vfife.numerics import dense, library
from vfife.numerics.dense import dot, norm, product, times
from vfife.numerics.routines import singular

SHAPES = [
    (1, 1),
    (2, 2),
    (3, 5),
    (5, 3),
    (12, 12),
    (13, 20),
    (20, 13),
    (31, 31),
    (4, 0),
    (0, 4),
    (1, 7),
    (7, 1),
]


def bits(*arrays: object) -> bytes:
    return b"".join((np.ascontiguousarray(one) + 0.0).tobytes() for one in arrays)  # type: ignore[operator]


def matrices(rows: int, columns: int, rank: int | None = None, count: int = 3) -> np.ndarray:
    rng = np.random.default_rng(100 * rows + columns)
    if rank is not None:
        return rng.normal(size=(count, rows, rank)) @ rng.normal(size=(count, rank, columns))
    return rng.normal(size=(count, rows, columns)) * 10.0 ** rng.uniform(-2.0, 2.0, size=(count, rows, 1))


@pytest.mark.parametrize(("rows", "columns"), SHAPES)
def test_products(rows: int, columns: int) -> None:
    a, b, x = matrices(rows, columns), matrices(columns, 4), matrices(columns, 1)[..., 0]
    assert np.allclose(product(a, b), a @ b, rtol=1e-13, atol=1e-12) and product(a, b[0]).shape == (
        3,
        rows,
        4,
    )
    assert bits(product(a[1], b[1])) == bits(product(a, b)[1]) and bits(product(a, b[1])[2]) == bits(
        product(a[2], b[1])
    )
    assert np.allclose(times(a, x), (a @ x[..., None])[..., 0], rtol=1e-13, atol=1e-12) and bits(
        times(a, x)[2]
    ) == bits(times(a[2], x[2]))
    assert bits(times(a[0], x)[1]) == bits(times(a[0], x[1]))
    assert (
        np.allclose(dot(a, a), (a * a).sum(-1), rtol=1e-13)
        and np.isclose(norm(a, axis=-2), np.linalg.norm(a, axis=-2), rtol=1e-13).all()
    )
    assert norm(np.array([3.0, 4.0])) == 5.0 and dot([1.0, 2.0], [3.0, 4.0]) == 11.0


@pytest.mark.parametrize(("rows", "columns"), SHAPES)
@pytest.mark.parametrize("loss", [0, 1, 3])
def test_singular_values_and_vectors(rows: int, columns: int, loss: int) -> None:
    k = min(rows, columns)
    a = matrices(rows, columns, max(k - loss, 0) if loss else None)
    left, size, right = dense.svd(a)
    scale = max(float(size.max(initial=0.0)), 1e-300)
    assert (
        np.abs(product(left[..., :k] * size[..., None, :], right[..., :k, :]) - a).max(initial=0.0)
        <= 2e-14 * scale
    )
    for q in (left, np.swapaxes(right, -1, -2)):
        assert np.abs(product(np.swapaxes(q, -1, -2), q) - np.eye(q.shape[-1])).max(initial=0.0) <= 1e-13
    assert (np.diff(size, axis=-1) <= 0.0).all() and np.abs(size - np.linalg.svd(a, compute_uv=False)).max(
        initial=0.0
    ) <= 2e-14 * scale
    assert bits(dense.singular_values(a)) == bits(size)
    thin = dense.svd(a, full=False)
    assert bits(*thin) == bits(
        np.ascontiguousarray(left[..., :k]), size, np.ascontiguousarray(right[..., :k, :])
    )
    assert bits(*(one[1] for one in (left, size, right))) == bits(*dense.svd(a[1]))  # alone as beside others


def test_small_singular_values_are_exact_to_their_own_last_digits() -> None:
    """Graded rows: one-sided rotations keep what a reduction to two diagonals loses."""
    exact = np.array([1.0, 1e-5, 1e-10, 1e-15])
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(4, 4)))[0]
    size = dense.singular_values(exact[:, None] * turn)
    assert np.abs(size / exact - 1.0).max() < 1e-14


@pytest.mark.parametrize(("rows", "columns"), [(2, 9), (6, 6), (9, 4)])
def test_rows_turned_round_change_signs_alone(rows: int, columns: int) -> None:
    """So that bearing and journal may be exchanged, or a mechanism mirrored: zeros and rows of one length
    have no sign that decides.
    """
    rng = np.random.default_rng(rows)
    for matrix in (
        rng.integers(-1, 2, (rows, columns)).astype(float),
        rng.normal(size=(rows, columns)),
        np.eye(rows, columns)[::-1].copy(),
    ):
        signs = np.where(np.arange(rows) % 2 == 0, -1.0, 1.0)
        for turned in (-matrix, signs[:, None] * matrix)[: 1 if rows > columns else 2]:
            one, other = dense.svd(matrix), dense.svd(turned)
            assert bits(*(np.abs(part) for part in one)) == bits(*(np.abs(part) for part in other))


def test_extreme_and_undefined_entries() -> None:
    a = matrices(4, 4)[0]
    for scale in (1e-290, 1e280):
        assert np.allclose(dense.singular_values(scale * a) / scale, dense.singular_values(a), rtol=1e-13)
    for wrong in (np.nan, np.inf):
        bad = a.copy()
        bad[1, 2] = wrong
        for function in (dense.svd, dense.singular_values, dense.eigh, dense.eigenvalue_sizes):
            with pytest.raises(np.linalg.LinAlgError):
                function(bad)
    assert dense.svd(np.zeros((3, 2)))[1].tolist() == [0.0, 0.0]


@pytest.mark.parametrize("size", [1, 2, 3, 8, 30])
def test_solutions_and_inverses(size: int) -> None:
    a, b = matrices(size, size), matrices(size, 3)
    found = dense.solve(a, b)
    assert np.abs(product(a, found) - b).max() <= 1e-11 * np.abs(b).max() and np.allclose(
        found, np.linalg.solve(a, b), rtol=1e-8, atol=1e-9
    )
    assert bits(dense.solve(a[1], b[1])) == bits(found[1]) and bits(dense.solve(a[1], b[1, :, 0])) == bits(
        found[1, :, 0].copy()
    )
    assert dense.determinant_sign(a).tolist() == np.linalg.slogdet(a)[0].tolist()
    assert np.abs(product(dense.inverse(a), a) - np.eye(size)).max() <= 1e-9
    assert dense.determinant_sign(np.zeros((size, size))) == 0.0
    with pytest.raises(np.linalg.LinAlgError):
        dense.solve(np.zeros((size, size)), b[0])


def test_pivots() -> None:
    assert dense.solve([[0.0, 2.0], [3.0, 0.0]], [2.0, 6.0]).tolist() == [2.0, 1.0]
    assert dense.determinant_sign(np.array([[0.0, 1.0], [1.0, 0.0]])) == -1.0
    assert np.allclose(dense.solve([[1e-20, 1.0], [1.0, 1.0]], [1.0, 2.0]), [1.0, 1.0], rtol=1e-15)


@pytest.mark.parametrize("size", [0, 1, 2, 5, 24])
def test_symmetric_matrices(size: int) -> None:
    a = matrices(size, size)
    a = a + np.swapaxes(a, -1, -2)
    values, vectors = dense.eigh(a)
    scale = max(float(np.abs(values).max(initial=0.0)), 1e-300)
    assert (
        np.abs(product(vectors * values[..., None, :], np.swapaxes(vectors, -1, -2)) - a).max(initial=0.0)
        <= 3e-14 * scale
    )
    assert np.abs(product(np.swapaxes(vectors, -1, -2), vectors) - np.eye(size)).max(initial=0.0) <= 1e-13
    assert (
        np.abs(values - np.linalg.eigvalsh(a)).max(initial=0.0) <= 3e-14 * scale
        and (np.diff(values, axis=-1) >= 0.0).all()
    )
    assert bits(*(one[2] for one in (values, vectors))) == bits(*dense.eigh(a[2]))
    values, vectors = dense.eigh(2.0 * np.eye(size))
    assert (values == 2.0).all() and np.abs(product(vectors, vectors.T) - np.eye(size)).max(
        initial=0.0
    ) == 0.0


@pytest.mark.parametrize("size", [1, 2, 3, 6, 20])
def test_eigenvalues_of_general_matrices(size: int) -> None:
    a = matrices(size, size)
    a[1, -1] = a[1, 0]  # singular
    found, known = np.sort(dense.eigenvalue_sizes(a), axis=-1), np.sort(np.abs(np.linalg.eigvals(a)), axis=-1)
    assert np.abs(found - known).max() <= 1e-10 * max(known.max(), 1.0)
    turn = np.array([[0.0, -2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, -5.0]])
    assert sorted(dense.eigenvalue_sizes(turn).tolist()) == [2.0, 2.0, 5.0]


@pytest.mark.parametrize(("rows", "columns"), SHAPES)
@pytest.mark.parametrize("full", [False, True])
def test_qr(rows: int, columns: int, full: bool) -> None:
    a = matrices(rows, columns)
    q, r = dense.qr(a, full)
    assert np.abs(product(q, r) - a).max(initial=0.0) <= 1e-14 * np.abs(a).max(initial=1e-300) * 30
    assert (
        np.abs(product(np.swapaxes(q, -1, -2), q) - np.eye(q.shape[-1])).max(initial=0.0) <= 1e-14
        and (np.tril(r, -1) == 0.0).all()
    )


def test_least_squares_and_pseudoinverses() -> None:
    for rows, columns, rank in ((6, 4, None), (4, 6, None), (6, 6, 4), (8, 5, 3)):
        a = matrices(rows, columns, rank)
        b = np.random.default_rng(3).normal(size=rows)
        assert np.allclose(
            dense.least_squares(a[0], b, 1e-10),
            np.linalg.lstsq(a[0], b, rcond=1e-10)[0],
            rtol=1e-9,
            atol=1e-9,
        )
        assert np.allclose(dense.pinv(a, 1e-10), np.linalg.pinv(a, rcond=1e-10), rtol=1e-8, atol=1e-9)


def arguments(name: str) -> list[object]:
    """What a routine is called with: two matrices, so that the second is reached."""
    rng = np.random.default_rng(7)
    a = rng.normal(size=(2, 7, 5))
    square = rng.normal(size=(2, 6, 6))
    square[1, 3] = square[1, 2] + square[1, 0]
    near = rng.uniform(0.01, 40.0, 30)
    return {
        "multiply": [a, rng.normal(size=(2, 5, 4)), np.zeros((2, 7, 4))],
        "multiply_vectors": [a, rng.normal(size=(2, 5)), np.zeros((2, 7))],
        "eliminate": [square, rng.normal(size=(2, 6, 3)), np.zeros(2)],
        "factors": [a, np.zeros((2, 7, 7)), np.zeros((2, 7, 5)), np.zeros(35 + 15 + 7)],
        "decompose": [
            a,
            np.zeros((2, 7, 7)),
            np.zeros((2, 5)),
            np.zeros((2, 5, 5)),
            np.zeros(35 + 50 + 25 + 7),
            2,
        ],
        "eigenvalues": [square, np.zeros((2, 6)), np.zeros((2, 6)), np.zeros((6, 6))],
        "factorise": [
            np.array([4.0, 1.0, 5.0, -2.0, 0.5, 6.0, 1.0, 7.0]),
            np.array([0.0, 2.0, 5.0, 7.0]),
            np.array([0.0, 0.0, 0.0, 2.0]),
            4,
            1e-9,
        ],
        "substitute_back": [
            np.array([4.0, 0.3, 5.0, -2.0, 0.5, 6.0, 1.0, 7.0]),
            np.array([0.0, 2.0, 5.0, 7.0]),
            np.array([0.0, 0.0, 0.0, 2.0]),
            near[:4],
            4,
        ],
        "turn_all": [near, np.zeros(30), np.zeros(30)],
        "raise_all": [near, rng.uniform(-3.0, 3.0, 30), np.zeros(30)],
        "exponentials": [near, np.zeros(30)],
        "logarithms": [near, np.zeros(30)],
        "directions_of": [near, rng.normal(size=30), np.zeros(30)],
    }[name]  # type: ignore[return-value]


@pytest.mark.parametrize("name", [routine.__name__ for routine in library.ROUTINES])
def test_compiled_routines_have_the_bits_of_plain_python(name: str) -> None:
    compiled, plain = arguments(name), arguments(name)
    library.compiled()[name](*compiled)
    library.plain()[name](*plain)
    first, second = ([one for one in each if isinstance(one, np.ndarray)] for each in (compiled, plain))
    assert bits(*first) == bits(*second)


def test_no_product_is_fused() -> None:
    """(1 + e)(1 - e) - 1 is -e^2 where product and difference are one operation, and 0 in two."""
    e = 2.0**-30
    assert dense.determinant_sign(np.array([[2.0, 2.0 * (1.0 - e)], [1.0 + e, 1.0]])) == 0.0


def test_rows_of_one_length_are_rotated_alike_when_one_is_turned_round() -> None:
    found = []
    for sign in (1.0, -1.0):
        room = [3.0, 1.0, sign * 1.0, sign * 3.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0]
        singular.orthogonalise(room, singular.Offsets(2, 2, 0, 0, M=0, J=4, squares=8, rank=0, X=0), 0.0)
        found.append([abs(one) for one in room])
    assert found[0] == found[1] and sorted(round(one, 12) for one in found[0][8:]) == [4.0, 16.0]
