from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mol_compactons import ContactLaw, InputError, Nesterenko, PowerContact
from tests.systems import Array

ONE = np.ones(1)
POINTS = np.array([-2.0, -0.7, 0.4, 1.0, 3.0])


@st.composite
def laws(draw: st.DrawFn) -> PowerContact:
    kind: Any = draw(st.sampled_from(["odd", "one_sided", "power", "rarefaction"]))
    n = draw(st.sampled_from({"power": [2, 3, 4], "rarefaction": [2, 4]}.get(kind, [1.5, 2.0, 2.7, 3.0])))
    linear = 0.0 if kind == "one_sided" else draw(st.floats(0, 2))
    return PowerContact(n, draw(st.floats(0.2, 3)), linear, kind)


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        (PowerContact(1.5, 2, 0.5), 2 * np.abs(POINTS) ** 1.5 * np.sign(POINTS) + 0.5 * POINTS),
        (PowerContact(1.5, 2, kind="one_sided"), 2 * np.maximum(POINTS, 0) ** 1.5),
        (PowerContact(2, 2, 0.5, "power"), 2 * POINTS**2 + 0.5 * POINTS),
        (PowerContact(3, 2, 0.5, "power"), 2 * POINTS**3 + 0.5 * POINTS),
        (PowerContact(2, 2, 0.5, "rarefaction"), -2 * POINTS**2 + 0.5 * POINTS),
    ],
)
def test_the_force_is_the_one_that_is_said(law: PowerContact, expected: Array) -> None:
    assert law.force(POINTS, ONE) == pytest.approx(expected, rel=1e-14)


@given(laws(), st.floats(-3, 3), st.floats(0.3, 2))
def test_stiffness_and_energy_belong_to_the_force(law: PowerContact, place: float, factor: float) -> None:
    assume(abs(place) > 1e-2)
    z, step, factors = np.array([place]), 1e-5, np.array([factor])
    slope = (law.force(z + step, factors) - law.force(z - step, factors)) / (2 * step)
    gain = (law.energy(z + step, factors) - law.energy(z - step, factors)) / (2 * step)
    assert law.stiffness(z, factors) == pytest.approx(slope, rel=1e-5, abs=1e-6)
    assert law.force(z, factors) == pytest.approx(gain, rel=1e-5, abs=1e-6)
    assert law.energy(np.zeros(1), factors) == 0


@given(laws(), st.floats(0.3, 3))
def test_the_factor_multiplies_the_nonlinear_part(law: PowerContact, factor: float) -> None:
    nonlinear = law.force(POINTS, ONE) - law.linear * POINTS
    changed = law.force(POINTS, np.array([factor])) - law.linear * POINTS
    assert changed == pytest.approx(factor * nonlinear, rel=1e-10, abs=1e-12)


@given(st.sampled_from([1.5, 2.0, 3.0]), st.floats(0, 2), st.floats(1e-3, 10), st.floats(0.2, 4))
def test_the_static_compression_holds_the_push(n: float, linear: float, push: float, factor: float) -> None:
    """In closed form without a spring, by a search with one; each contact of its own strength."""
    law, factors = PowerContact(n, 1.3, linear), np.array([1.0, factor, 1.0])
    stress = law.static_compression(push, factors)
    assert law.force(stress, factors) == pytest.approx(np.full(3, push), rel=1e-12)
    assert stress[0] == stress[2]


@dataclass(frozen=True)
class Exponential(ContactLaw):
    """F = exp(z) - 1: no power law."""

    def force(self, z: Array, factor: Array) -> Array:
        return np.asarray(factor * np.expm1(z))

    def stiffness(self, z: Array, factor: Array) -> Array:
        return np.asarray(factor * np.exp(z))

    def energy(self, z: Array, factor: Array) -> Array:
        return np.asarray(factor * (np.expm1(z) - z))


@dataclass(frozen=True)
class Soft(Exponential):
    """F = 1 - exp(-z), which holds no more than 1."""

    def force(self, z: Array, factor: Array) -> Array:
        return np.asarray(-factor * np.expm1(-z))


@dataclass(frozen=True)
class Linear(Exponential):
    """F = z."""

    def force(self, z: Array, factor: Array) -> Array:
        return factor * z


@given(st.floats(1e-6, 1e6), st.floats(0.1, 10))
def test_any_law_has_its_static_compression(push: float, factor: float) -> None:
    stress = Exponential().static_compression(push, np.array([1.0, factor]))
    assert stress == pytest.approx(np.log1p(push / np.array([1.0, factor])), rel=1e-12)
    assert Exponential().static_compression(0.0, np.ones(4)).tolist() == [0.0] * 4


def test_more_than_the_contacts_can_hold_is_refused() -> None:
    assert Soft().static_compression(0.5, ONE) == pytest.approx(np.log(2))
    with pytest.raises(InputError, match=r"compression = 2 is more than its contacts can hold; choose a lower one"):
        Soft().static_compression(2.0, ONE)
    with pytest.raises(InputError, match=r"compression = 1e\+62 is more than its contacts can hold"):
        Linear().static_compression(1e62, ONE)
    assert Linear().static_compression(1e59, ONE) == pytest.approx(1e59)
    with pytest.raises(InputError, match="compression is for laws that resist it"):
        PowerContact(2, kind="rarefaction").static_compression(1.0, ONE)


@pytest.mark.parametrize(
    ("kind", "n", "compression", "tension"),
    [
        ("odd", 1.5, True, True),
        ("one_sided", 1.5, True, False),
        ("power", 2, True, False),
        ("power", 3, True, True),
        ("rarefaction", 2, False, True),
    ],
)
def test_what_a_contact_resists(kind: Any, n: float, compression: bool, tension: bool) -> None:
    law = PowerContact(n, kind=kind)
    assert (law.resists(1), law.resists(-1)) == (compression, tension)
    assert (law.force(np.array([1.0]), ONE)[0] > 0) == compression
    assert (law.force(np.array([-1.0]), ONE)[0] < 0) == tension


def test_the_continuum_of_a_power_law_is_nesterenkos_equation() -> None:
    """With the same force F(S) = C S^n + c0^2 S, and waves of a long wavelength as fast as in the chain."""
    law = PowerContact(3, 1.3, 0.5)
    assert law.continuum == Nesterenko(n=3, strength=1.3, grain_distance=1.0, prestress=0.5)
    assert law.continuum.frequency_squared(1e-3, 0.7) == pytest.approx(law.stiffness(np.array([0.7]), ONE)[0] * 1e-6, rel=1e-5)
    with pytest.raises(InputError, match="The continuum of a chain of Exponential contacts is not known"):
        _ = Exponential().continuum
    assert Exponential().coefficients is None


@pytest.mark.parametrize(
    ("attempt", "words"),
    [
        (lambda: PowerContact(1), "n = 1 must be larger than 1"),
        (lambda: PowerContact(2, strength=0), "strength = 0 must be positive"),
        (lambda: PowerContact(2, linear=-1), "linear = -1 must not be negative"),
        (lambda: PowerContact(1.5, kind="power"), "'power' needs a whole exponent, not n = 1.5"),
        (lambda: PowerContact(3, kind="rarefaction"), "'rarefaction' needs an even exponent, not n = 3"),
        (lambda: PowerContact(2, linear=1, kind="one_sided"), "'one_sided' has no linear term"),
    ],
)
def test_bad_input_is_named(attempt: Callable[[], Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        attempt()


@pytest.mark.parametrize("law", [PowerContact(1.5), PowerContact(2, 1.3, 0.5, "power")])
def test_every_field_is_checked(law: PowerContact) -> None:
    for name in ("n", "strength", "linear", "kind"):
        with pytest.raises(InputError, match=rf"PowerContact\.{name} = '\?' must be"):
            replace(law, **{name: "?"})  # type: ignore[arg-type]
