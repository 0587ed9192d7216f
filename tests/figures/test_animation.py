from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import (
    CVODE,
    ChainCompacton,
    Compacton,
    GranularChain,
    InputError,
    Lattice,
    NearestNeighbours,
    PowerContact,
    Simulation,
    Symplectic,
    continuum_of,
    run,
)
from mol_compactons.figures.animation import _pictures, _times, animate, courses
from tests.systems import one_compacton


@pytest.fixture(scope="module")
def pair() -> xr.Dataset:
    """Two compactons, 24 frames."""
    waves = [Compacton(1, 6), Compacton(0.25, 16)]
    return run(replace(one_compacton(size=150, t_end=5, frames=24), initial=waves, title="a pair"))


@pytest.fixture(scope="module")
def chain() -> list[xr.Dataset]:
    """A chain and its continuum."""
    discrete = Simulation(
        title="a chain",
        equation=GranularChain(PowerContact(n=3 / 2), ends="held"),
        grid=Lattice(size=40),
        scheme=NearestNeighbours(),
        initial=[ChainCompacton(speed=1, center=10)],
        t_end=8,
        frames=11,
        integrator=Symplectic(step=0.05),
    )
    smooth = replace(continuum_of(discrete, points_per_site=8), integrator=CVODE(rtol=1e-4))
    return [run(discrete), run(smooth)]


def by_pillow(path: Path) -> list[np.ndarray[Any, Any]]:
    from PIL import Image, ImageSequence

    with Image.open(path) as film:
        return [np.asarray(picture.convert("RGB")) for picture in ImageSequence.Iterator(film)]


def by_ffmpeg(path: Path, shape: tuple[int, ...]) -> list[np.ndarray[Any, Any]]:
    exe = pytest.importorskip("imageio_ffmpeg").get_ffmpeg_exe()
    command = [exe, "-loglevel", "error", "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(command, capture_output=True, check=True).stdout
    return list(np.frombuffer(raw, np.uint8).reshape(-1, *shape))


def crest(picture: np.ndarray[Any, Any]) -> float:
    """How far to the right the highest point of the line stands, as a share of the picture."""
    colors = picture.astype(int)
    near = (colors[..., 2] - colors[..., 0] > 50).nonzero()  # the line is blue, all else grey
    top = near[0].min()
    return float(near[1][near[0] <= top + 2].mean() / picture.shape[1])


@pytest.mark.parametrize("ending", ["mp4", "gif", "webp"])
def test_a_film_decoded_again_is_what_was_drawn(pair: xr.Dataset, ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"film.{ending}"
    if ending == "mp4":
        pytest.importorskip("imageio_ffmpeg")
    assert animate([pair], path) == 24
    times = np.linspace(0, 5, 24)
    drawn = [picture[..., :3] for picture in _pictures(courses([pair]), times, False, 0.0)]
    decoded = by_ffmpeg(path, drawn[0].shape) if ending == "mp4" else by_pillow(path)
    assert len(decoded) == 24
    for seen, made in zip(decoded, drawn, strict=True):
        assert seen.shape == made.shape
        assert np.abs(seen.astype(int) - made).mean() < 2
    places = [crest(picture) for picture in decoded]
    assert (np.diff(places) > 0).all(), "the higher wave moves to the right"
    assert places[-1] - places[0] == pytest.approx(5 / 30 * 0.92, rel=0.12)


def test_seen_from_the_wave_it_stands_still(pair: xr.Dataset) -> None:
    times = np.linspace(0, 5, 24)
    places = [crest(picture) for picture in _pictures(courses([pair]), times, False, 1.0)]
    assert np.ptp(places) < 0.02
    (one,) = courses([pair])
    np.testing.assert_array_equal(one.at(5.0, 0.0), pair.W.values[-1])
    np.testing.assert_allclose(one.at(5.0, 30.0 / 5), pair.W.values[-1], atol=1e-12)


@pytest.mark.parametrize("together", [False, True])
def test_a_chain_and_its_continuum_move_together(chain: list[xr.Dataset], together: bool, tmp_path: Path) -> None:
    discrete, smooth = courses(chain)
    for t in (0.0, 4.0, 8.0):
        positions = [float(one.x[one.at(t, 0.0).argmax()]) for one in (discrete, smooth)]
        assert positions[0] == pytest.approx(positions[1], abs=0.7)
        assert positions[0] == pytest.approx(10 + t * np.sqrt(1.0), abs=1.0)
    path = tmp_path / "film.webp"
    assert animate(chain, path, together=together) == max(one.sizes["t"] for one in chain)
    pictures = by_pillow(path)
    assert pictures[0].shape[0] == (360 if together else 720)
    assert np.abs(pictures[0].astype(int) - pictures[-1]).mean() > 0.1


def test_of_uneven_times_each_picture_shows_the_frame_of_its_clock() -> None:
    uneven = run(replace(one_compacton(size=150, t_end=10), output_times=(0, 1, 1.5, 10), frames=4))
    (one,) = courses([uneven])
    np.testing.assert_array_equal(_times([one], 400), [0, 1, 1.5, 10])
    np.testing.assert_array_equal(_times([one], 2), [0, 10])
    crests = [float(one.x[one.at(t, 1.0).argmax()]) for t in (0, 1, 1.5, 10, 1.2)]
    assert np.ptp(crests) < 0.5, "seen from the wave it stands still, whichever frame is shown"


def test_what_cannot_be_shown_is_one_sentence(pair: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for broken, words in (
        (pair.isel(t=slice(0, 0)), "has 0"),
        (pair.where(pair.t < 1), "holds NaN or infinity"),
        (pair.where(pair.t < 1, np.inf), "holds NaN or infinity"),
    ):
        with pytest.raises(InputError, match=words):
            animate([broken.assign_attrs(pair.attrs)], tmp_path / "film.gif")
    pytest.importorskip("imageio_ffmpeg")
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(tmp_path / "nowhere"))
    with pytest.raises(InputError, match="encoder of films cannot be started"):
        animate([pair], tmp_path / "film.mp4", most_frames=3)
    assert not list(tmp_path.iterdir())


def test_any_title_can_stand_in_a_film(pair: xr.Dataset, tmp_path: Path) -> None:
    for title in (r"$\foo$", "_hidden", ""):
        assert (
            animate([pair, pair], tmp_path / "a.gif", labels=[title, title], together=True, most_frames=3, overwrite=True) == 3
        )


def test_an_opened_gap_does_not_crush_the_rest() -> None:
    values = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, -50.0]])
    limits = {}
    for kind in ("one_sided", "odd"):
        law = PowerContact(1.5, kind=kind)
        chain = Simulation(
            equation=GranularChain(law),
            grid=Lattice(20),
            scheme=NearestNeighbours(),
            initial=[Compacton(1, 10)],
            t_end=1,
            frames=2,
        )
        attributes = {"simulation": chain.to_json()}
        result = xr.Dataset({"R": (("t", "k"), values)}, {"t": [0.0, 1.0], "k": [0, 1, 2]}, attributes)
        (one,) = courses([result], [kind])
        limits[kind] = one.limits
    assert limits["one_sided"] == pytest.approx((-0.5 - 0.09, 1.09))
    assert limits["odd"][0] < -50, "of contacts that pull it is a wave"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"datasets": []}, "no result to make a film of"),
        ({"rate": 0.0}, "rate = 0 pictures a second"),
        ({"most_frames": 1}, "most_frames = 1 must lie"),
        ({"labels": ["a", "b"]}, "1 results and 2 labels"),
        ({"speed": np.inf}, "speed = inf"),
    ],
)
def test_bad_input_is_named(pair: xr.Dataset, arguments: dict[str, Any], words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        animate(**{"datasets": [pair], "path": tmp_path / "film.gif"} | arguments)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="two frames or more"):
        animate([pair.isel(t=[0])], tmp_path / "film.gif")


@pytest.mark.parametrize("length", [10, 110])
def test_no_label_leaves_the_picture(pair: xr.Dataset, length: int) -> None:
    """The corners above the axes stay white, however long the labels are."""
    films = courses([pair, pair], ["a" * length, "b" * length])
    picture = next(iter(_pictures(films, np.array([0.0, 5.0]), True, 0.0)))[..., :3]
    assert (picture[:18, :4] == 255).all()
    assert (picture[:18, -4:] == 255).all()
