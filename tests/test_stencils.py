import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import stencils
from mol_compactons.stencils import Stencil, convolve
from tests.systems import dense_stencil, fitted_order


@given(st.integers(0, 1000), st.integers(5, 12))
def test_convolve_is_the_circulant_matrix(seed: int, size: int) -> None:
    rng = np.random.default_rng(seed)
    u, out = rng.normal(size=size), np.empty(size)
    stencil = Stencil(tuple(rng.normal(size=5)), 0, 1)
    convolve(np.array(stencil.coefficients), u, out)
    assert np.allclose(out, dense_stencil(stencil, size, 1.0) @ u, atol=1e-14)


@pytest.mark.parametrize(
    ("stencil", "derivative", "order"),
    [
        (stencils.SECOND_WIDE, 2, 2),
        (stencils.SECOND_NEAREST, 2, 2),
        (stencils.SECOND_FIVE_POINT, 2, 4),
    ],
)
def test_symbols_approach_the_derivative_at_the_stated_order(stencil: Stencil, derivative: int, order: int) -> None:
    sizes = [20, 40, 80]
    theta = 2 * np.pi / np.array(sizes)
    errors = np.abs(stencil.symbol(theta) / (1j * theta) ** derivative - 1)
    assert (stencil.derivative, stencil.order) == (derivative, order)
    assert fitted_order(sizes, errors.tolist()) == pytest.approx(order, abs=0.05)


def test_the_compact_pair_is_a_sixth_order_first_derivative() -> None:
    sizes = [10, 20, 40]
    theta = 2 * np.pi / np.array(sizes)
    pair = stencils.COMPACT_FIRST.symbol(theta) / stencils.COMPACT_MASS.symbol(theta)
    assert fitted_order(sizes, np.abs(pair / (1j * theta) - 1).tolist()) == pytest.approx(6, abs=0.1)


def test_the_wide_second_difference_has_the_symbol_of_the_theory() -> None:
    """-theta^2 (1 - theta^2 / 3 + ...): second order, whatever the order of the first derivative."""
    theta = np.array([1e-2])
    symbol = stencils.SECOND_WIDE.symbol(theta).real / -(theta**2)
    assert (1 - symbol) / theta**2 == pytest.approx(1 / 3, rel=1e-3)
