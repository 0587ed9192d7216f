from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from mol_compactons import (
    CentralScheme,
    CompactScheme,
    ConservativeScheme,
    Equation,
    FourierScheme,
    GranularChain,
    GranularCompacton,
    Grid,
    InputError,
    Lattice,
    NearestNeighbours,
    Nesterenko,
    PowerContact,
    RosenauHyman,
    Scheme,
    SemiDiscretization,
)
from mol_compactons.open_set import loaded
from mol_compactons.schemes import best_scheme
from mol_compactons.schemes.viscosity import default_viscosity

GRID, RING = Grid(30, 100), Lattice(40)
CHAIN = GranularChain(PowerContact(2))


def own_schemes() -> list[type[Scheme]]:
    return [cls for name, cls in loaded(Scheme).items() if ":" not in name]


@pytest.mark.parametrize(
    ("equation", "grid", "kind"),
    [
        (GranularCompacton(2), GRID, ConservativeScheme),
        (RosenauHyman(3, 3), GRID, ConservativeScheme),
        (Nesterenko(2), GRID, CompactScheme),
        (CHAIN, RING, NearestNeighbours),
    ],
)
def test_the_best_scheme_is_the_one_that_says_that_it_suits_best(
    equation: Equation, grid: Grid | Lattice, kind: type[Scheme]
) -> None:
    best = best_scheme(equation, grid, speed=1.0)
    assert isinstance(best, kind)
    offers = [cls.default_for(equation, grid, 1.0) for cls in loaded(Scheme).values()]
    assert best.suits(equation) == max(offer.suits(equation) for offer in offers if offer is not None) > 0
    best.discretize(equation, grid)


DAMPED = [
    (ConservativeScheme, GranularCompacton(3), 0.03),
    (ConservativeScheme, RosenauHyman(3, 3), 0.03),
    (ConservativeScheme, RosenauHyman(2, 2, absolute=True), 0.03),
    (CompactScheme, Nesterenko(3), 0.03),
    (CentralScheme, GranularCompacton(3), 0.03),
    (CentralScheme, RosenauHyman(2, 2), None),
]


@pytest.mark.parametrize(("kind", "equation", "unit"), DAMPED)
def test_the_default_viscosity_goes_with_the_speed_of_the_waves(
    kind: type[Scheme], equation: Equation, unit: float | None
) -> None:
    """A wave of twice the speed on the same grid has half the time, and dies as much on its way."""
    schemes = [kind.default_for(equation, GRID, speed) for speed in (1.0, 4.0)]
    slow, fast = (scheme.viscosities for scheme in schemes if scheme is not None)
    assert slow == pytest.approx((0, unit or default_viscosity(False, GRID.spacing)))
    assert fast == pytest.approx((0, 4 * slow[1]))
    assert [getattr(scheme, "viscosity_order", None) for scheme in schemes] == [6, 6]


def test_where_the_flux_is_not_odd_the_default_viscosity_grows_as_the_grid_is_refined() -> None:
    """In grid units, as 1 / h^2."""
    coarse, fine = (default_viscosity(False, spacing) for spacing in (0.2, 0.1))
    assert fine == pytest.approx(4 * coarse)
    assert coarse > default_viscosity(True, 0.2) == default_viscosity(True, 0.1)


@dataclass(frozen=True)
class Unknown(Equation):
    """An equation without any flux."""

    variables = ("u",)


def test_an_equation_that_nothing_suits_is_refused() -> None:
    with pytest.raises(InputError, match="No scheme that is loaded suits Unknown; give the equation a local_flux"):
        best_scheme(Unknown(), GRID, 1.0)


def test_what_suits_an_equation_takes_it_and_what_does_not_refuses_it() -> None:
    for cls in own_schemes():
        scheme = cls()
        for equation, grid in ((GranularCompacton(2), GRID), (RosenauHyman(3, 2), GRID), (Nesterenko(2), GRID), (CHAIN, RING)):
            if scheme.suits(equation) > 0:
                system = scheme.discretize(equation, grid)
                assert (system.size, system.components) == (grid.size, len(equation.variables))
            else:
                with pytest.raises(InputError):
                    scheme.discretize(equation, grid)


@pytest.mark.parametrize("scheme", [ConservativeScheme(), CompactScheme(), FourierScheme()])
def test_a_study_checks_with_a_scheme_of_another_class(scheme: Scheme) -> None:
    other = scheme.independent_alternative(GranularCompacton(2), GRID)
    assert other is not None
    assert type(other) is not type(scheme)
    assert other.suits(GranularCompacton(2)) > 0


class Refined(CompactScheme):
    """A scheme that is another's with something added."""


def test_settings_and_descendants_are_no_other_kind() -> None:
    schemes = (ConservativeScheme(order=2), ConservativeScheme(order=4), CompactScheme(), Refined())
    independent = [[one.is_independent_of(other) for other in schemes] for one in schemes]
    assert independent == [[False, False, True, True]] * 2 + [[True, True, False, False]] * 2


def test_where_there_is_no_other_scheme_there_is_no_check() -> None:
    assert NearestNeighbours().independent_alternative(CHAIN, RING) is None


def test_only_a_chain_has_sites_that_are_real() -> None:
    assert {cls.__name__: cls().refines for cls in own_schemes()} == {
        cls.__name__: cls is not NearestNeighbours for cls in own_schemes()
    }


def test_viscosity_can_be_changed_where_there_is_one() -> None:
    for cls in own_schemes():
        scheme = cls()
        assert scheme.with_viscosity(*scheme.viscosities) == scheme
        if cls is NearestNeighbours:
            with pytest.raises(InputError, match="NearestNeighbours has no viscosity; choose no viscosities"):
                scheme.with_viscosity(1e-3, 0.0)
        else:
            assert scheme.with_viscosity(1e-3, 0.2).viscosities == (1e-3, 0.2)
            assert scheme.with_viscosity(1e-3, 0.2).label == scheme.label


def test_a_label_says_the_choices_without_the_viscosity() -> None:
    assert ConservativeScheme(order=6, viscosity=1e-3).label == "ConservativeScheme(order=6)"
    assert CompactScheme("nearest", grid_viscosity=0.1).label == "CompactScheme(second_difference=nearest)"
    assert replace(ConservativeScheme(), viscosity_order=6).label == "ConservativeScheme(order=4, viscosity_order=6)"
    assert NearestNeighbours().label == "NearestNeighbours()"


@dataclass(frozen=True)
class Least(Scheme):
    """Says only what it must."""

    def suits(self, equation: Equation) -> float:
        return 0.0

    def discretize(self, equation: Equation, grid: Grid | Lattice) -> SemiDiscretization:
        raise InputError("Least takes nothing.")


def test_what_a_scheme_does_not_say_has_a_default() -> None:
    assert Least().formal_order == 2
    assert Least().viscosities == (0.0, 0.0)
    assert Least().label == f"{__name__}:Least()"
    assert Least.default_for(GranularCompacton(2), GRID, 1.0) == Least()
    assert Least.as_check_of(ConservativeScheme(), GranularCompacton(2), GRID) == (0.0, Least())


@pytest.mark.parametrize("scheme", [CompactScheme(), CentralScheme()])
def test_what_an_equation_adds_along_t_is_that_of_the_state_and_the_spacing(scheme: Scheme) -> None:
    @dataclass(frozen=True)
    class WithAMoment(GranularCompacton):
        def diagnostics(self, state: NDArray[np.float64], spacing: float) -> dict[str, float]:
            return {"moment": spacing * float((state[0] ** 4).sum())}

    state = np.linspace(0, 1, GRID.size)[None]
    found = scheme.discretize(WithAMoment(3), GRID).diagnostics(state)
    assert found == {"moment": pytest.approx(0.3 * (np.linspace(0, 1, 100) ** 4).sum())}
