"""The compiled singular value decomposition beside LAPACK's."""

import mpmath
import numpy as np
import pytest

from holonom.numeric.svd import singular_values, svd

SHAPES = [(6, 6), (6, 7), (3, 6), (6, 2), (7, 3), (3, 3), (1, 4), (4, 1), (1, 1)]
SHAPES += [(5, 5), (6, 5), (4, 6), (6, 60), (8, 7)]


def check(A, scale=1.0):
    U, s, Vt = svd(A)
    m, n = A.shape[-2:]
    k = min(m, n)
    identity = [np.broadcast_to(np.eye(size), (*A.shape[:-2], size, size)) for size in (m, n)]
    np.testing.assert_allclose(U @ np.swapaxes(U, -1, -2), identity[0], atol=1e-13)
    np.testing.assert_allclose(Vt @ np.swapaxes(Vt, -1, -2), identity[1], atol=1e-13)
    np.testing.assert_allclose(U[..., :k] * s[..., None, :] @ Vt[..., :k, :], A, atol=1e-13 * scale)
    np.testing.assert_allclose(s, np.linalg.svd(A, compute_uv=False), atol=1e-13 * scale)
    assert (np.diff(s, axis=-1) <= 0.0).all()
    np.testing.assert_allclose(singular_values(A), s, rtol=1e-14, atol=1e-300)


@pytest.mark.parametrize(("m", "n"), SHAPES)
@pytest.mark.parametrize("lead", [(), (5,), (2, 3), (0,)])
def test_random_matrices(m, n, lead):
    check(np.random.default_rng(m * n).normal(size=(*lead, m, n)))


@pytest.mark.parametrize(("m", "n"), SHAPES)
@pytest.mark.parametrize("rank", [0, 1, 2, 5])
def test_singular_matrices_have_whole_bases_too(m, n, rank):
    rng = np.random.default_rng(rank)
    check(rng.normal(size=(m, rank)) @ rng.normal(size=(rank, n)))
    A = np.zeros((m, n))
    A[: min(rank, m)] = 1.0
    check(A)


@pytest.mark.parametrize("scale", [1e-300, 1e-150, 1e150, 1e300])
def test_any_scale(scale):
    check(scale * np.random.default_rng(1).normal(size=(6, 7)), scale)


def test_equal_singular_values_and_a_matrix_in_another_order():
    check(np.eye(6))
    check(np.asfortranarray(np.random.default_rng(2).normal(size=(6, 6))))
    check(np.random.default_rng(2).normal(size=(6, 12))[:, ::2])


def test_small_singular_values_of_badly_scaled_rows_are_right_to_the_last_digits():
    """Where LAPACK is right to 1e-16 of the largest one only."""
    rows, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(6, 6)))
    scales = 10.0 ** -np.arange(0.0, 24.0, 4.0)
    np.testing.assert_allclose(singular_values(scales[:, None] * rows), scales, rtol=1e-13)


@pytest.mark.parametrize("small", [1e-60, 1e-75, 1e-100, 1e-139, 1e-200])
def test_rows_of_hardly_any_length_leave_bases_orthogonal(small):
    """Their squares are numbers still, the product of two such squares is none."""
    check(np.array([[1.0, 0.0, 0.0], [0.0, small, small], [0.0, small, 2.0 * small]]))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_ends_as_nan(bad):
    A = np.random.default_rng(4).normal(size=(3, 6, 6))
    A[1, 2, 3] = bad
    _, s, _ = svd(A)
    assert np.isnan(s[1]).any()
    assert np.isfinite(s[[0, 2]]).all()
    assert np.isnan(svd(A[1])[1]).any()
    assert np.isnan(singular_values(A[1])).any()
    A = np.ones((2, 7, 8))
    A[1, 2, 3] = bad
    assert np.isnan(svd(A)[1]).any(-1).tolist() == [False, True]


@pytest.mark.parametrize("gap", [0.0, 1e-15, 1e-12, 1e-8, 1e-4])
@pytest.mark.parametrize(("m", "n"), [(6, 6), (6, 7), (3, 6), (5, 6), (7, 4)])
def test_clusters_of_singular_values_leave_vectors_orthogonal(m, n, gap):
    """Where angles stay large however small the cosines are: the sweep that ends it all is not the first quiet one."""
    rng, k = np.random.default_rng(5), min(m, n)
    U, V = (np.linalg.qr(rng.normal(size=(500, size, size)))[0] for size in (m, n))
    s = np.where(np.arange(k) < k // 2, 1.0, 1e-3) * (1.0 + gap * rng.normal(size=(500, k)))
    U, s, Vt = svd(U[:, :, :k] * s[:, None] @ V[:, :k])
    for Q, size in ((U, m), (Vt, n)):
        np.testing.assert_allclose(Q @ np.swapaxes(Q, 1, 2), np.broadcast_to(np.eye(size), Q.shape), atol=5e-15)


def test_small_singular_values_keep_their_digits_beside_exact_ones():
    rng = np.random.default_rng(6)
    with mpmath.workdps(60):
        for _ in range(10):
            A = 10.0 ** rng.uniform(-20.0, 0.0, (6, 1)) * rng.normal(size=(6, 7))
            M = mpmath.matrix(A.tolist())
            exact = sorted(mpmath.sqrt(x) for x in mpmath.eigsy(M * M.T, eigvals_only=True))[::-1]
            np.testing.assert_allclose(singular_values(A), [float(x) for x in exact], rtol=1e-13)


def test_a_matrix_without_rows():
    U, s, Vt = svd(np.empty((2, 0, 3)))
    assert U.shape == (2, 0, 0)
    assert s.shape == (2, 0)
    np.testing.assert_array_equal(Vt, np.broadcast_to(np.eye(3), (2, 3, 3)))
