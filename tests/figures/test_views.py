from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from mol_compactons import Compacton, InputError, first_collision, run, track
from mol_compactons.figures.views import (
    KINDS,
    OUTLINE,
    ROUNDING,
    SIZES,
    WIDTHS,
    _slopes,
    paths,
    picture,
    portrait,
    snapshots,
    spacetime,
    spectrum,
    window,
)
from tests.systems import one_compacton


@pytest.fixture(scope="module")
def one() -> xr.Dataset:
    return run(one_compacton(size=150, t_end=5, frames=11))


@pytest.fixture(scope="module")
def pair() -> xr.Dataset:
    """A fast wave that passes a slow one and goes round the ring."""
    waves = [Compacton(1, 6), Compacton(0.25, 16)]
    return run(replace(one_compacton(size=300, t_end=30, frames=151), initial=waves))


def axes() -> Any:
    return Figure().subplots()


def test_snapshots_are_frames_and_the_exact_wave_stands_beside_them(one: xr.Dataset) -> None:
    panel = axes()
    snapshots(one, panel, (0, 2.6, 5))
    drawn = panel.lines
    assert [line.get_label() for line in drawn if not line.get_label().startswith("_")] == [
        "t = 0",
        "t = 2.5",
        "t = 5",
        "exact",
    ]
    for line, frame in zip(drawn[::2], (0, 5, 10), strict=True):
        np.testing.assert_array_equal(line.get_ydata(), one.W.values[frame])
    for line, t in zip(drawn[1::2], (0, 2.5, 5), strict=True):
        assert np.abs(line.get_ydata() - one.W.sel(t=t).values).max() < 0.3
        assert float(line.get_ydata().max()) == pytest.approx(np.sqrt(2), rel=0.01)
    assert len({line.get_linestyle() for line in drawn[::2]}) == 3, "told apart in grey"
    for computed, known in zip(drawn[::2], drawn[1::2], strict=True):
        assert computed.get_zorder() > known.get_zorder()
        assert computed.get_linewidth() < known.get_linewidth() / 2, "the exact wave is seen on both sides of its line"
    with pytest.raises(InputError, match="t = 7 is beyond the result, which goes from 0 to 5"):
        snapshots(one, axes(), (7,))


def test_without_an_exact_wave_only_frames_are_drawn(pair: xr.Dataset) -> None:
    panel = axes()
    snapshots(pair, panel)
    assert len(panel.lines) == 4


def test_the_map_has_the_values_of_the_field(one: xr.Dataset) -> None:
    panel = axes()
    spacetime(one, panel)
    (mesh,) = panel.collections
    np.testing.assert_array_equal(np.asarray(mesh.get_array()).reshape(one.W.shape), one.W.values)
    assert mesh.get_clim()[1] == pytest.approx(float(one.W.max()))
    dark = one.copy()
    dark["W"] = -one.W
    dark.W.attrs = one.W.attrs
    spacetime(dark, panel)
    low, high = panel.collections[1].get_clim()
    assert low == -high


def test_another_result_is_drawn_below_at_the_times_of_the_first(one: xr.Dataset) -> None:
    """Between its frames by interpolation: here its frames are every second one of the first."""
    coarse = one.isel(t=slice(0, None, 2))
    panel = axes()
    snapshots(one, panel, (0, 2.5, 5), beside=coarse, called="coarse")
    below = panel.lines[1::2]
    np.testing.assert_allclose(below[0].get_ydata(), one.W.values[0], atol=1e-13)
    np.testing.assert_allclose(below[1].get_ydata(), (one.W.values[4] + one.W.values[6]) / 2, atol=1e-13)
    np.testing.assert_allclose(below[2].get_ydata(), one.W.values[10], atol=1e-13)
    assert below[-1].get_label() == "coarse"
    with pytest.raises(InputError, match="t = 5 is beyond the second result, which goes from 0 to 3"):
        snapshots(one, axes(), (0, 5), beside=one.isel(t=slice(0, 7)))


def test_below_zero_is_outlined_in_a_map(pair: xr.Dataset) -> None:
    """Both ends of the colours are dark in grey. Around a dark wave there is a dashed line at a quarter of its depth."""
    dark = pair.assign(W=(-pair.W).assign_attrs(pair.W.attrs))
    lines = {}
    for name, dataset in (("bright", pair), ("dark", dark)):
        panel = axes()
        spacetime(dataset, panel)
        lines[name] = panel.collections[1:]
    assert not lines["bright"]
    (outline,) = lines["dark"]
    assert outline.levels == pytest.approx([-OUTLINE * float(pair.W.max())])
    assert outline.get_linestyle()[0][1] is not None, "dashed"


def test_paths_are_those_of_track_around_the_ring(pair: xr.Dataset) -> None:
    panel = axes()
    paths(pair, panel)
    tracks = track(pair, newborn=False)
    for line, number in zip(panel.lines[::2], range(2), strict=True):
        x, t = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        known = np.isfinite(x)
        np.testing.assert_allclose(x[known], tracks.position.values[known, number] % 30, atol=1e-9)
        np.testing.assert_array_equal(t, pair.t.values)
    assert np.isnan(panel.lines[0].get_xdata()).any(), "no line is drawn across where it comes round"
    shift = float(first_collision(tracks).phase_shift[0])
    assert panel.lines[0].get_label() == f"wave 0, shifted by {shift:.3g}"
    assert np.asarray(panel.lines[0].get_xdata())[0] == pytest.approx(6, abs=0.05)


def test_the_spectrum_is_the_fourier_transform(one: xr.Dataset) -> None:
    panel = axes()
    spectrum(one, panel)
    for line, frame in zip(panel.lines, (0, -1), strict=True):
        sizes = np.abs(np.fft.rfft(one.W.values[frame]))[1:] / 150
        np.testing.assert_allclose(line.get_ydata(), sizes[sizes > ROUNDING * sizes.max()])
        assert line.get_xdata()[0] == pytest.approx(2 * np.pi / 30)


def test_rounding_errors_do_not_crush_the_spectrum(one: xr.Dataset) -> None:
    """Two equal waves half a period apart have no odd coefficients, and no wave has none at all."""
    twice = one.W.values[-1] + np.roll(one.W.values[-1], 75)
    values = np.stack([np.zeros(150), twice])
    double = one.isel(t=[0, -1]).assign(W=(("t", "x"), values, one.W.attrs))
    panel = axes()
    spectrum(double, panel)
    still, moving = panel.lines
    assert (still.get_label(), np.size(still.get_xdata())) == ("t = 0: zero", 0)
    numbers = np.asarray(moving.get_xdata()) * 30 / (2 * np.pi)
    np.testing.assert_array_equal(np.round(numbers) % 2, 0)
    assert np.asarray(moving.get_ydata()).min() > 1e-16


def test_small_ticks_have_the_size_of_large_ones(one: xr.Dataset) -> None:
    figure = picture(one, "spectrum", style="journal")
    figure.canvas.draw()
    ticks = figure.axes[0].yaxis.get_minor_ticks() + figure.axes[0].yaxis.get_major_ticks()
    assert {tick.label1.get_fontsize() for tick in ticks} == {SIZES["journal"] - 1}


def test_a_portrait_of_a_period_is_closed() -> None:
    """W = sqrt(2 + cos x): W W_x = -sin(x) / 2, at the ends of the period too."""
    x = 2 * np.pi / 200 * np.arange(200, dtype=np.float64)
    w: Any = np.sqrt(2 + np.cos(x + 1))
    np.testing.assert_allclose(_slopes(w[None, :], x, 2 * np.pi)[0] * w, -np.sin(x + 1) / 2, atol=1e-3)


def test_the_portrait_of_a_compacton_of_n_3_is_half_an_ellipse(one: xr.Dataset) -> None:
    """W = M cos(K z) has W_x^2 = K^2 (M^2 - W^2), with M^2 = 2 and K = 1/2."""
    panel = axes()
    portrait(one, panel, (0,))
    (line,) = panel.lines
    w, slope = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    inside = w > 0.4
    np.testing.assert_allclose(slope[inside] ** 2, (2 - w[inside] ** 2) / 4, atol=0.02)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("style", WIDTHS)
def test_every_picture_can_be_drawn_in_every_style(one: xr.Dataset, kind: str, style: str) -> None:
    figure = picture(one, kind, style=style)
    figure.canvas.draw()
    assert figure.get_figwidth() == WIDTHS[style]
    (panel, *_) = figure.axes
    assert panel.xaxis.label.get_fontsize() == SIZES[style]
    assert panel.get_legend() is None, "the legend stands outside, where it covers nothing"


def test_a_window_is_a_part(one: xr.Dataset) -> None:
    part = window(one, 5, 12.05)
    assert (float(part.x[0]), float(part.x[-1])) == (5, 12)
    figure = picture(one, "waterfall", part=(5, None))
    assert figure.axes[0].get_xlim() == (5, float(one.x[-1]))
    with pytest.raises(InputError, match="holds no two points of x, from 0 to 29"):
        window(one, 40, 50)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"kind": "pie"}, "no picture 'pie'; it may be waterfall"),
        ({"kind": "map", "style": "poster"}, "no style 'poster'"),
        ({"kind": "paths", "part": (1, 2)}, "shows the whole line"),
        ({"kind": "map", "times": [1.0]}, "shows all times"),
        ({"kind": "map", "beside": xr.Dataset()}, "shows one result; leave out the second"),
    ],
)
def test_bad_input_is_named(one: xr.Dataset, arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        picture(one, **arguments)


def test_times_may_be_an_array_and_none_lies_beyond_the_result(one: xr.Dataset) -> None:
    for kind in ("snapshots", "portrait"):
        assert len(picture(one, kind, times=np.array([0.0, 5.0])).axes[0].lines) >= 2
        with pytest.raises(InputError, match="t = 99 is beyond the result"):
            picture(one, kind, times=[99.0])
