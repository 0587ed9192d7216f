from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mol_compactons.results.netcdf import NetCDFRecorder
from mol_compactons.results.recorder import MemoryRecorder, Recorder
from mol_compactons.results.schema import Layout
from tests.systems import Array

SIZE = 5

FRAMES = st.lists(arrays(float, (2, SIZE), elements=st.floats(-1e300, 1e300)), max_size=4)


def layout(series_per_frame: int = 1) -> Layout:
    """Two components on five points, and two numbers along t."""

    def own(role: str) -> dict[str, str]:
        return {"long_name": role, "units": "1", "role": role}

    return Layout(
        fields={"S": own("field"), "v": own("field")},
        series={"mass": own("conserved"), "skewness": own("diagnostic")},
        space="x",
        coordinates=np.linspace(0, 2, SIZE),
        coordinate_attributes={"long_name": "place", "units": "1", "period": 2.5},
        frames=4,
        attributes={"title": "by hand", "status": "running"},
        series_per_frame=series_per_frame,
    )


def recorded(recorder: Recorder, frames: list[Array]) -> xr.Dataset:
    """Frames at distances of 0.25, with numbers on the way to each but the first."""
    for index, frame in enumerate(frames):
        parts = range(recorder.layout.series_per_frame if index else 1)
        between = [(0.25 * (index - part / len(parts)), float(frame[0, 0]), float(index - part)) for part in reversed(parts)]
        recorder.append(frame, np.array(between))
    recorder.close({"status": "complete", "solver_steps": 3})
    return recorder.dataset()


@given(FRAMES)
def test_what_is_recorded_comes_back_bit_for_bit(frames: list[Array]) -> None:
    dataset = recorded(MemoryRecorder(layout()), frames)
    assert dict(dataset.sizes) == {"t": len(frames), "x": SIZE}
    for index, frame in enumerate(frames):
        assert np.array_equal(dataset.S.values[index], frame[0])
        assert np.array_equal(dataset.v.values[index], frame[1])
        assert float(dataset.mass[index]) == frame[0, 0]
    assert dataset.t.values.tolist() == [0.25 * index for index in range(len(frames))]
    assert dataset.skewness.values.tolist() == list(range(len(frames)))


@settings(max_examples=20)
@given(FRAMES, st.integers(1, 4))
def test_memory_and_file_hold_the_same(frames: list[Array], parts: int) -> None:
    with TemporaryDirectory() as folder:
        disk = recorded(NetCDFRecorder(layout(parts), Path(folder, "frames.nc"), overwrite=False), frames)
        memory = recorded(MemoryRecorder(layout(parts)), frames)
        xr.testing.assert_identical(disk.load(), memory)
        disk.close()
    if parts > 1 and frames:
        assert memory.sizes["t_series"] == (len(frames) - 1) * parts + 1
        assert np.allclose(memory.t_series, 0.25 / parts * np.arange(memory.sizes["t_series"]), rtol=0, atol=1e-15)
        assert np.array_equal(memory.skewness_series[::parts], memory.skewness)
        assert memory.mass_series.dims == ("t_series",)


@settings(max_examples=20)
@given(FRAMES, st.integers(2, 4), st.integers(0, 4))
def test_a_file_is_taken_over_from_memory_and_from_a_file(frames: list[Array], parts: int, kept: int) -> None:
    whole = recorded(MemoryRecorder(layout(parts)), frames)
    kept = min(kept, len(frames))
    with TemporaryDirectory() as folder:
        other = NetCDFRecorder(layout(parts), Path(folder, "other.nc"), overwrite=False)
        other.take_over(whole, kept)
        other.close({"status": "complete", "solver_steps": 3})
        with other.dataset() as found:
            expected = whole.isel(t=slice(kept), t_series=slice((kept - 1) * parts + 1 if kept else 0))
            xr.testing.assert_identical(found.load(), expected)


def test_a_frame_is_kept_as_it_was() -> None:
    """The state that a run hands over is scratch space of its integrator."""
    recorder, state = MemoryRecorder(layout()), np.ones((2, SIZE))
    recorder.append(state, np.array([[0.0, 1.0, 0.0]]))
    state[:] = 7.0
    recorder.append(state, np.array([[1.0, 7.0, 0.0]]))
    assert recorder.dataset().S.values[:, 0].tolist() == [1.0, 7.0]


def test_attributes_of_the_end_replace_those_of_the_beginning() -> None:
    own = layout()
    recorder = MemoryRecorder(own)
    assert recorder.dataset().attrs["status"] == "running"
    recorder.close({"status": "complete"})
    assert recorder.dataset().attrs == {"title": "by hand", "status": "complete"}
    assert own.attributes["status"] == "running"


def test_a_number_that_is_missing_is_an_error_and_no_gap() -> None:
    recorder = MemoryRecorder(layout())
    with pytest.raises(ValueError, match="broadcast"):
        recorder.append(np.ones((2, SIZE)), np.array([[0.0, 1.0]]))
    assert recorder.dataset().sizes["t"] == 0
