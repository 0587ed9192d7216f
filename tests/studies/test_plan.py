from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mol_compactons import InputError, Rosenbrock, Simulation
from mol_compactons.assignment import assign
from mol_compactons.studies.plan import MOST_MEMBERS, Axis, Plan, Variant, drawn, listed, product, together
from tests.studies.sweeps import small


def sizes(members: list[Variant]) -> list[int]:
    return [member.simulation().grid.size for member in members]


def test_a_product_has_all_combinations_the_last_field_fastest() -> None:
    plan = product(small(), {"grid.size": [60, 80], "integrator": ["Rosenbrock(rtol=1e-3)", Rosenbrock(rtol=1e-5), "IDA"]})
    members = list(plan)
    assert plan.shape == (2, 3)
    assert plan.dimensions == ("size", "integrator")
    assert sizes(members) == [60, 60, 60, 80, 80, 80]
    assert [member.index for member in members] == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)]
    assert members[1].simulation().integrator == Rosenbrock(rtol=1e-5)
    assert members[1].label == "grid.size=60 integrator=Rosenbrock(rtol=1e-05)"


def test_a_member_is_named_by_what_it_is() -> None:
    texts, numbers = product(small(), {"grid.size": ["60", "80"]}), product(small(80), {"grid.size": [60, 80]})
    assert [member.name for member in texts] == [member.name for member in numbers]
    everywhere = {member.name for member in product(small(), {"grid.size": range(60, 90), "t_end": [1, 2]})}
    assert len(everywhere) == 60


def test_fields_that_vary_together_are_one_axis() -> None:
    plan = together(small(), {"grid.size": [60, 80], "initial.0.center": ["10", 12.5]})
    assert (plan.shape, plan.dimensions) == ((2,), ("member",))
    assert [member.simulation().initial[0].center for member in plan] == [10, 12.5]  # type: ignore[attr-defined]
    mixed = Plan(small(), [Axis({"t_end": [1, 2, 3]}), Axis({"grid.size": [60, 80], "title": ["a", "b"]})])
    assert (mixed.shape, mixed.dimensions) == ((3, 2), ("t_end", "member_1"))


def test_a_list_fills_what_a_member_does_not_say_from_the_simulation() -> None:
    members = list(listed(small(70), [{"grid.size": 60}, {"t_end": 1}, {"integrator": "IDA", "t_end": 2}]))
    assert sizes(members) == [60, 70, 70]
    assert [member.simulation().t_end for member in members] == [0.2, 1, 2]
    assert members[1].simulation().integrator == small().integrator


@given(st.integers(0, 2**32 - 1), st.integers(1, 30), st.floats(1e-3, 1), st.floats(1.5, 1e3))
def test_random_values_repeat_themselves_and_stay_in_their_range(seed: int, count: int, low: float, ratio: float) -> None:
    ranges = {"initial.0.speed": (low, low * ratio), "t_end": (1.0, 2.0)}
    first, again = (drawn(small(), ranges, count, seed, ["initial.0.speed"]) for _ in range(2))
    values = np.array(first.axes[0].changes["initial.0.speed"])
    assert first.described() == again.described()
    assert values.size == count
    assert ((low * (1 - 1e-12) <= values) & (values <= low * ratio * (1 + 1e-12))).all()


def test_logarithms_are_drawn_evenly() -> None:
    values = np.array(drawn(small(), {"t_end": (1e-4, 1e4)}, 4000, 1, ["t_end"]).axes[0].changes["t_end"])
    assert abs(np.mean(np.log10(values))) < 0.15
    assert abs(np.mean(values < 1) - 0.5) < 0.05
    assert drawn(small(), {"t_end": (1e-4, 1)}, 5, 1).described() != drawn(small(), {"t_end": (1e-4, 1)}, 5, 2).described()


def test_dimensions_have_names_that_no_other_has() -> None:
    plan = product(small(), {"grid.length": [30], "integrator.rtol": [1e-3, 1e-4], "initial.0.speed": [1]})
    assert plan.dimensions == ("length", "rtol", "speed")
    two = Plan(small(), [Axis({"initial.0.center": [10]}), Axis({"grid.left": [0]})])
    assert two.dimensions == ("center", "left")


def test_it_is_json_and_settings_that_do_not_fit_are_found_by_their_member_alone() -> None:
    plan = product(small(), {"grid.size": [5, 60], "integrator": [Rosenbrock(), "IDA"]})
    assert json.loads(json.dumps(plan.described())) == plan.described()
    with pytest.raises(InputError, match="choose at least 9 points"):
        next(iter(plan)).simulation()
    assert isinstance(list(plan)[-1].simulation(), Simulation)


@pytest.mark.parametrize(
    ("varied", "words"),
    [
        ({}, "varies nothing"),
        ({"grid.size": []}, "has no value"),
        ({"grid.sise": [60]}, "did you mean 'grid.size'"),
        ({"scheme.viscosty": [1e-3], "grid.size": [60]}, "did you mean 'scheme.viscosity'"),
        ({"t_end": range(1, 1001), "grid.size": range(1000), "frames": range(1000)}, f"1e.09 members, and {MOST_MEMBERS} are"),
        ({"t_end": ["-" * 1000 + "1"]}, "levels deep"),
    ],
)
def test_a_plan_that_cannot_be_is_one_sentence(varied: dict[str, list[object]], words: str) -> None:
    with pytest.raises(InputError, match=words) as refused:
        product(small(), varied)
    assert len(str(refused.value)) < 300


def test_other_mistakes_are_sentences_too() -> None:
    with pytest.raises(InputError, match="need as many values each; these have 1, 2"):
        together(small(), {"t_end": [1], "grid.size": [60, 80]})
    with pytest.raises(InputError, match="'t_end' is varied twice"):
        Plan(small(), [Axis({"t_end": [1]}), Axis({"t_end": [2]})])
    with pytest.raises(InputError, match="changes no field"):
        Axis({})
    with pytest.raises(InputError, match="list of members is empty"):
        listed(small(), [])
    with pytest.raises(InputError, match="count = 0"):
        drawn(small(), {"t_end": (1, 2)}, 0)
    with pytest.raises(InputError, match="give a smaller and a larger number"):
        drawn(small(), {"t_end": (2, 1)}, 3)
    with pytest.raises(InputError, match="give positive numbers"):
        drawn(small(), {"t_end": (0, 1)}, 3, logarithmic=["t_end"])


@given(
    st.lists(
        st.sampled_from(["grid.size", "initial.0.speed", "scheme.grid_viscosity", "integrator", "title"]),
        unique=True,
        min_size=1,
    )
)
@settings(max_examples=15)
def test_members_are_what_assigning_their_changes_gives(paths: list[str]) -> None:
    values: dict[str, list[object]] = {
        "grid.size": [60, "80"],
        "initial.0.speed": [0.5, "1/3"],
        "scheme.grid_viscosity": [0.01, 0.02],
        "integrator": ["Rosenbrock()", "IDA(rtol=1e-5)"],
        "title": ["a", "b"],
    }
    for member in product(small(), {path: values[path] for path in paths}):
        changed = assign(small(), member.changes)
        assert member.simulation() == changed


def test_a_field_and_a_part_of_it_can_be_varied_together() -> None:
    plan = product(small(), {"integrator": ["Rosenbrock()", "IDA()"], "integrator.rtol": [1e-3, 1e-5]})
    found = {(type(one.simulation().integrator).__name__, one.simulation().integrator.rtol) for one in plan}  # type: ignore[attr-defined]
    assert found == {(name, rtol) for name in ("Rosenbrock", "IDA") for rtol in (1e-3, 1e-5)}
