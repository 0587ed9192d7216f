from __future__ import annotations

import base64
import json
import re

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    GranularChain,
    Impact,
    InputError,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Simulation,
    Symplectic,
    check_up,
    drift,
    first_collision,
    run,
    track,
)
from mol_compactons.pages import plots
from mol_compactons.pages.document import Page, Section, rendered
from mol_compactons.pages.result import MOST_FRAMES, MOST_NUMBERS, moving_of, page_of_result


def part(page: Page, name: str) -> Section:
    (found,) = [section for section in page.sections if section.name == name]
    return found


def test_it_says_what_track_doctor_and_info_say(pair: xr.Dataset) -> None:
    page = page_of_result(pair, "complete")
    tracks = track(pair)
    waves, collisions = part(page, "waves").tables
    assert [float(row[1 + 3]) for row in waves.rows] == pytest.approx(
        [float(one.dropna("t")[-1]) for one in tracks["height"].T], rel=0.1
    )
    shifts = [float(row[2]) for row in collisions.rows]
    assert shifts == pytest.approx(first_collision(tracks)["phase_shift"].values, rel=1e-5)
    (checks,) = part(page, "doctor").tables
    assert [list(row) for row in checks.rows] == [[one.check, one.verdict, one.sentence] for one in check_up(pair)]
    (drifts,) = part(page, "kept").tables
    largest = {row[0]: float(row[1]) for row in drifts.rows}
    assert largest == {str(name): pytest.approx(float(abs(one).max()), rel=0.01) for name, one in drift(pair).items()}


def test_the_settings_repeat_the_run(pair: xr.Dataset) -> None:
    assert Simulation.from_json(part(page_of_result(pair, "complete"), "settings").code).to_json() == pair.attrs["simulation"]


def test_the_motion_is_the_field(pair: xr.Dataset) -> None:
    moving, told = moving_of(pair)
    assert told == []
    numbers = np.frombuffer(base64.b64decode(moving.encoded), "<f4").reshape(pair.W.shape)
    np.testing.assert_array_equal(numbers, pair.W.values.astype("f4"))
    assert moving.map.data[0].zmin == -moving.map.data[0].zmax, "a field of both signs has its zero in the middle"


def long(pair: xr.Dataset, frames: int, points: int) -> xr.Dataset:
    t, x = np.linspace(0, 1, frames), np.linspace(0, 30, points, endpoint=False)
    field = xr.DataArray(
        np.random.default_rng(1).normal(size=(frames, points)), {"t": t, "x": x}, ("t", "x"), "W", pair.W.attrs
    )
    field["x"].attrs = {"period": 30.0, "spacing": 30 / points}
    return field.to_dataset().assign_attrs(pair.attrs)


@pytest.mark.parametrize(("frames", "points"), [(2000, 300), (50, 60_000), (3000, 5000)])
def test_of_a_long_run_as_much_is_shown_as_has_room(pair: xr.Dataset, frames: int, points: int) -> None:
    moving, told = moving_of(long(pair, frames, points))
    ((_, x, values),) = moving.series
    assert values.size <= 1.01 * MOST_NUMBERS
    assert moving.t.size <= MOST_FRAMES
    assert (moving.t[0], moving.t[-1], x[0]) == (0, 1, 0)
    assert f"of {frames} frames" in told[0]


def test_400_frames_of_1200_points_are_below_8_megabytes(pair: xr.Dataset) -> None:
    moving, told = moving_of(long(pair, 400, 1200))
    assert told == []
    assert len(rendered(Page("a", "complete", [], [], moving)).encode()) < 7.7e6


def test_a_chain_and_its_continuum(chain: tuple[xr.Dataset, xr.Dataset]) -> None:
    page = page_of_result(chain[0], "complete", chain[1])
    assert page.moving
    (_, sites, discrete), (_, points, smooth) = page.moving.series
    at_sites = np.array([np.interp(sites, points, row) for row in smooth])
    apart = np.linalg.norm(at_sites - discrete, axis=1) / np.linalg.norm(discrete, axis=1)
    assert apart[0] < 0.02
    (picture,) = part(page, "comparison").pictures
    assert apart == pytest.approx(np.array(picture.figure.data[0].y), abs=0.03)


def test_a_result_with_gaps_is_shown_with_them(pair: xr.Dataset) -> None:
    torn = pair.copy(deep=True)
    torn.W[-1, 3:9] = np.nan
    assert "NaN" not in page_of_result(torn, "failed").moving.caption  # type: ignore[union-attr]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_a_field_without_a_number_that_can_be_drawn_has_a_page(pair: xr.Dataset, value: float) -> None:
    moving, _ = moving_of(pair.assign(W=xr.full_like(pair.W, value)))
    text = rendered(Page("a", "failed", [], [], moving))
    data = re.search('id="data">(.*?)</script>', text)
    assert data
    json.loads(data[1], parse_constant=lambda word: pytest.fail(f"{word} is no JSON"))


def test_a_chain_in_displacements_is_shown_by_its_stresses() -> None:
    simulation = Simulation(
        equation=GranularChain(PowerContact(n=3 / 2), form="displacements", ends="free"),
        grid=Lattice(size=30),
        scheme=NearestNeighbours(),
        initial=[Impact(velocity=1.0)],
        t_end=6,
        frames=13,
        integrator=Symplectic(step=0.05),
    )
    result = run(simulation)
    moving, _ = moving_of(result)
    assert moving.name == "R"
    ((_, _, values),) = moving.series
    np.testing.assert_array_equal(values, -np.diff(result.Q.transpose("t", "k").values, axis=1))
    low, high = moving.profile.layout.yaxis.range
    assert high > values.max()
    assert low > -values.max(), "gaps, which may be wide, are cut off"


def test_of_a_long_run_some_points_of_its_lines_are_drawn(pair: xr.Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plots, "MOST_POINTS", 20)
    page = page_of_result(pair, "complete")
    for name in ("waves", "kept"):
        (picture,) = part(page, name).pictures
        assert {len(one.x) for one in picture.figure.data} == {20}
        assert picture.caption.endswith("Drawn are 20 of 57 points.")


def test_one_frame_is_no_motion(pair: xr.Dataset) -> None:
    with pytest.raises(InputError, match=r"has 1 frame\(s\); at least 2"):
        page_of_result(pair.isel(t=[0]), "complete")
