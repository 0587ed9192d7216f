from __future__ import annotations

import pytest

from mol_compactons import (
    CollisionOver,
    Compacton,
    ConservativeScheme,
    GranularCompacton,
    Grid,
    InputError,
    Rosenbrock,
    Simulation,
    first_collision,
    run,
    track,
)


def pair(t_end: float, *centers: float) -> Simulation:
    waves = [Compacton(1, centers[0]), Compacton(0.25, centers[1])]
    scheme = ConservativeScheme(4, grid_viscosity=0.03, viscosity_order=6)
    return Simulation(GranularCompacton(2), Grid(80, 320), waves, t_end, scheme, 4 * int(t_end) + 1, Rosenbrock(rtol=1e-4))


def test_a_collision_that_is_over_stops_a_run() -> None:
    """Not before the waves have met, nor while they are one on the other; the shifts can be read from what is there."""
    dataset = run(pair(100, 8, 20), stop=[CollisionOver()])
    assert dataset.attrs["status"].startswith("stopped at t = ")
    assert "the waves met by t = " in dataset.attrs["status"]
    assert 25 < float(dataset.t[-1]) < 80
    outcome = first_collision(track(dataset, newborn=False))
    assert outcome["phase_shift"].values == pytest.approx([1.59, -4.6], abs=0.15)


def test_waves_that_do_not_meet_are_left_to_the_end() -> None:
    assert run(pair(10, 30, 8), stop=[CollisionOver()]).attrs["status"] == "complete"


@pytest.mark.parametrize(("fields", "words"), [({"accuracy": 0}, "accuracy = 0"), ({"apart": 1}, "apart = 1")])
def test_bad_settings_are_named(fields: dict[str, float], words: str) -> None:
    with pytest.raises(InputError, match=f"{words} must lie between 0 and 1"):
        CollisionOver(**fields)
