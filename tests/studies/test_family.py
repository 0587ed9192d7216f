from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mol_compactons import (
    CompactScheme,
    ConservativeScheme,
    Family,
    InputError,
    Midpoint,
    NearestNeighbours,
    Rosenbrock,
    Simulation,
    Symplectic,
    run,
)
from mol_compactons.assignment import assign
from mol_compactons.integrators.base import steps_between
from mol_compactons.studies.family import CONSERVATIVE, INVISCID, VISCOUS, Member
from tests.studies.simulations import chain, single


def test_what_is_left_empty_is_chosen_from_the_simulation() -> None:
    """A quarter, half and all of its points; its scheme and one of another kind; ten times and once its tolerance."""
    family = Family().completed(single(size=240))
    assert family.sizes == (60, 120, 240)
    assert family.schemes[0] == ConservativeScheme(order=4)
    assert [type(scheme) for scheme in family.schemes[1:]] != [ConservativeScheme]
    assert len(family.schemes) == 2
    assert family.tolerances == pytest.approx((1e-4, 1e-5))
    assert family.limits == {INVISCID: (0.0,)}
    assert family.completed(single(size=240)) == family


def test_the_viscosity_of_the_simulation_says_which_limit_is_approached() -> None:
    viscous = replace(single(), scheme=ConservativeScheme(viscosity=1e-3))
    tied = replace(single(), scheme=ConservativeScheme(grid_viscosity=0.1))
    assert Family().completed(viscous).limits == {VISCOUS: (2e-3, 1e-3)}
    assert Family().completed(tied).limits == {CONSERVATIVE: (0.2, 0.1)}
    both = Family(viscosities=(1e-3, 2e-3), grid_viscosities=(0.1,)).completed(single())
    assert both.limits == {CONSERVATIVE: (0.1,), VISCOUS: (2e-3, 1e-3)}


@given(
    st.lists(st.integers(60, 200), min_size=1, max_size=3, unique=True),
    st.lists(st.sampled_from([1e-3, 1e-4, 1e-5]), min_size=1, max_size=3, unique=True),
    st.lists(st.sampled_from([0.0, 1e-3, 2e-3]), min_size=1, max_size=3, unique=True),
)
def test_members_differ_in_one_thing_at_a_time(sizes: list[int], tolerances: list[float], viscosities: list[float]) -> None:
    """Each grid with each viscosity at the tightest tolerance; the other tolerances on the finest grid alone."""
    schemes = (ConservativeScheme(), CompactScheme())
    family = Family(tuple(sizes), schemes, tuple(viscosities), tolerances=tuple(tolerances)).completed(single())
    members = list(family.members(single()))
    assert len(members) == 2 * (len(sizes) * len(viscosities) + len(tolerances) - 1)
    assert len({member.label for member in members}) == len(members)
    for member in members:
        assert member.limit == VISCOUS
        assert member.simulation.grid.size == member.size
        assert member.simulation.scheme.viscosities == (member.viscosity, 0.0)
        assert member.simulation.integrator.own_tolerance == member.tolerance
        assert member.simulation.scheme.label == member.scheme
        if member.tolerance != min(tolerances):
            assert (member.size, member.viscosity) == (max(sizes), min(viscosities))


def test_cells_are_the_places_of_the_members() -> None:
    family = Family(viscosities=(1e-3, 2e-3), grid_viscosities=(0.1,)).completed(single())
    assert [cell for cell, _ in family.cells()] == [member.cell for member in family.members(single())]
    assert len(set(family.cells())) == len(list(family.cells()))


def test_kinds_of_schemes_are_classes() -> None:
    """Other settings of one class are no other kind."""
    schemes = (ConservativeScheme(order=2), ConservativeScheme(order=4), CompactScheme())
    general = replace(single(), integrator=Rosenbrock())
    members = [Member(INVISCID, scheme.label, 0.0, 1e-6, replace(general, scheme=scheme)) for scheme in schemes]
    independent = [[one.is_independent_of(other) for other in members] for one in members]
    assert independent == [[False, False, True]] * 2 + [[True, True, False]]


def test_a_viscosity_in_grid_units_stays_one() -> None:
    family = Family(sizes=(60, 120), schemes=(ConservativeScheme(),), grid_viscosities=(0.2,), tolerances=(1e-5,))
    for member in family.completed(single()).members(single()):
        assert member.limit == CONSERVATIVE
        assert member.simulation.scheme.viscosities == (0.0, 0.2)


def test_a_family_of_a_chain_varies_its_tolerance_alone() -> None:
    """Three, five and ten steps between two frames; the wave and the sites stay what they are."""
    simulation = replace(chain(), integrator=Symplectic(step=0.05))
    family = Family().completed(simulation)
    members = list(family.members(simulation))
    assert [member.tolerance for member in members] == pytest.approx([0.5 / 3, 0.1, 0.05])
    assert {member.simulation.grid for member in members} == {simulation.grid}
    assert all(np.array_equal(member.simulation.initial_state(), simulation.initial_state()) for member in members)


def test_the_absolute_tolerance_goes_along() -> None:
    simulation = assign(single(), {"integrator": "CVODE(rtol=1e-4, atol=1e-3)"})
    family = Family(sizes=(60, 90), tolerances=(1e-3, 1e-4), schemes=(ConservativeScheme(), CompactScheme(viscosity=0)))
    for member in family.completed(simulation).members(simulation):
        assert getattr(member.simulation.integrator, "atol", None) == pytest.approx(10 * member.tolerance)


def test_the_steps_of_the_midpoint_rule_are_its_tolerances() -> None:
    simulation = assign(single(size=80), {"integrator": "Midpoint(step=0.02)", "t_end": "0.2", "frames": "5"})
    members = list(Family().completed(simulation).members(simulation))
    steps = sorted({member.tolerance for member in members})
    assert steps == pytest.approx([0.05 / 3, 0.025])
    for member in members:
        assert isinstance(member.simulation.integrator, Midpoint)
        assert member.simulation.integrator.step == member.tolerance


def test_each_scheme_gets_an_integrator_that_can_take_it() -> None:
    family = assign(Family(), {"schemes": "[ConservativeScheme, CompactScheme, FourierScheme]", "sizes": "[40, 80]"})
    simulation = single()
    for member in family.completed(simulation).members(simulation):
        member.simulation.integrator.check_system(member.simulation.discretize())
        kind = {"ConservativeScheme": "band", "CompactScheme": "band", "FourierScheme": "krylov"}[member.scheme.split("(")[0]]
        assert getattr(member.simulation.integrator, "linear_solver", None) == kind


@given(st.integers(1, 40), st.floats(0.01, 1), st.sampled_from([Symplectic, Midpoint]))
def test_a_ladder_of_steps_has_no_two_that_are_one(per_frame: int, share: float, kind: type[Symplectic | Midpoint]) -> None:
    """Whatever the step: as many different numbers of steps between two frames as the family has members."""
    ring = chain() if kind is Symplectic else single(size=60)
    interval = ring.t_end / (ring.frames - 1)
    simulation = replace(ring, integrator=kind(step=interval / (per_frame - 1 + share)))
    members = list(Family(sizes=() if kind is Symplectic else (60,)).completed(simulation).members(simulation))
    counts = {steps_between(0.0, interval, member.simulation.integrator.own_tolerance) for member in members}
    own = steps_between(0.0, interval, simulation.integrator.own_tolerance)
    assert len(counts) == len({member.tolerance for member in members}) == (3 if kind is Symplectic else 2)
    assert own in counts
    for member in members:
        assert steps_between(0.0, interval, member.tolerance) * member.tolerance == pytest.approx(interval)


def test_the_step_that_is_taken_gives_the_same_run() -> None:
    """0.02 between frames that are 0.05 apart is a third of that, bit for bit."""
    simulation = replace(single(size=60), integrator=Midpoint(step=0.02), t_end=0.2, frames=5)
    taken = replace(simulation, integrator=Midpoint(step=Midpoint(step=0.02).taken(0.05)))
    assert np.array_equal(run(taken).W, run(simulation).W)


@pytest.mark.parametrize(
    ("attempt", "words"),
    [
        (lambda: Family(sizes=(60, 60)), "sizes = 60, 60 holds a value twice"),
        (lambda: Family(viscosities=(-1,)), "is negative"),
        (lambda: Family(viscosities=(1e-3,), grid_viscosities=(0.1, -1)), "is negative"),
        (lambda: Family(tolerances=(0,)), "is not positive"),
        (lambda: Family(tolerances=(1e-5, 0)), "is not positive"),
        (lambda: Family(accuracy=2), "accuracy = 2 must lie between 0 and 1"),
        (lambda: Family(schemes=(CompactScheme(), CompactScheme())), "holds a value twice"),
        (lambda: Family(sizes=(10, 20)).completed(chain()), "sizes is not to be varied: a chain has no grid to refine"),
        (lambda: Family(viscosities=(1e-3,)).completed(chain()), "viscosities is not to be varied"),
        (
            lambda: Family(tolerances=(0.49, 0.3)).completed(replace(chain(), integrator=Symplectic())),
            "frames that are 0.5 apart, and two of these come to 0.25; choose others",
        ),
        (
            lambda: Family(schemes=(NearestNeighbours(),)).completed(single()),
            "NearestNeighbours does not suit GranularCompacton; choose other schemes",
        ),
    ],
)
def test_bad_families_are_named(attempt: Callable[[], Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        attempt()


@pytest.mark.parametrize("simulation", [single(), chain()])
def test_what_is_complete_stays_as_it_is(simulation: Simulation) -> None:
    complete = Family().completed(simulation)
    assert complete.completed(simulation) == complete
