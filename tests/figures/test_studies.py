from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from mol_compactons import CompactScheme, ConservativeScheme, Family, InputError, judge
from mol_compactons.figures import convergence_overview, scheme_errors, schemes_overview
from mol_compactons.figures.style import MARKERS
from tests.figures.arrangement import places
from tests.studies.by_hand import spacing, study


def test_the_distances_of_the_ladder_are_drawn_against_the_spacing() -> None:
    tree = judge(study(lambda member: 1e-3 * spacing(member) ** 2))
    figure = convergence_overview(tree)
    quantities = tree["ladder"].to_dataset()["quantity"].values.tolist()
    panels = {axes.get_title().split(":")[0]: axes for axes in figure.axes if axes.get_title()}
    assert list(panels) == quantities
    assert places(figure) == [(0, column) for column in range(4)]
    assert len(quantities) <= 4
    (line, *others) = [line for line in panels["profile"].lines if line.get_marker() in tuple(MARKERS)]
    h, distance = np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)
    assert h.tolist() == [0.5, 0.25, 0.125]
    assert np.polyfit(np.log(h), np.log(distance), 1)[0] == pytest.approx(2, abs=1e-3)
    assert len(others) == 1
    assert panels["profile"].get_title() == "profile: converged"
    assert "by hand" in [text.get_text() for text in figure.texts]
    figure.canvas.draw()


def test_each_limit_and_viscosity_has_a_line_with_its_name() -> None:
    family = Family(schemes=(ConservativeScheme(), CompactScheme()), viscosities=(2e-3, 1e-3), grid_viscosities=(0.1,))
    figure = convergence_overview(judge(study(lambda member: 1e-3 * spacing(member), family)))
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    bars = [label for label in labels if label.startswith("error bar of the limit, ")]
    assert len(labels) == len(set(labels)) == 6 + len(bars)
    assert len(bars) == 2
    marked = [line for line in figure.axes[0].lines if line.get_marker() in tuple(MARKERS)]
    assert len({(line.get_marker(), line.get_linestyle()) for line in marked}) == 6, "told apart in grey"
    assert figure.axes[0].get_ylabel() == "relative distance from the limit"
    assert "conservative, ConservativeScheme(order=4), viscosity 0.1" in labels
    assert "viscous, CompactScheme(second_difference=wide), viscosity 0.001" in labels


def test_each_panel_has_the_error_bars_of_its_limits_and_the_slopes_1_2_and_4() -> None:
    tree = judge(study(lambda member: 1e-3 * spacing(member) ** 2))
    summary = tree["summary"].to_dataset()
    figure = convergence_overview(tree)
    quantities = summary["quantity"].values.tolist()
    for axes, quantity in zip(figure.axes, quantities, strict=False):
        row = summary.sel(quantity=quantity)
        bars = (row["error"] / row["scale"]).values
        drawn = [np.asarray(line.get_ydata()) for line in axes.lines if line.get_color() == "grey"]
        assert [bar[0] for bar in drawn] == pytest.approx([bar for bar in bars if np.isfinite(bar) and bar > 0])
        slopes = [line for line in axes.lines if line.get_color() == "lightgrey"]
        known = bool((tree["ladder"].to_dataset()["distance"].sel(quantity=quantity) > 0).any())
        for line, slope in zip(slopes, (1, 2, 4) if known else (), strict=True):
            h, size = np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)
            assert np.polyfit(np.log(h), np.log(size), 1)[0] == pytest.approx(slope)
    assert any(np.isfinite(summary["error"].values).ravel())
    assert not any(axes.axison for axes in figure.axes[len(quantities) :])


def test_each_title_has_the_verdicts_of_its_quantity() -> None:
    tree = judge(study(lambda member: 0.1 * np.sign(0.3 - spacing(member)) / spacing(member)))
    titles = [axes.get_title() for axes in convergence_overview(tree).axes]
    assert "profile: not converged" in titles


def several() -> xr.Dataset:
    """The schemes of studies by hand on two problems, for one n."""
    tables = []
    for number, name in enumerate(("one", "other"), start=1):
        tree = judge(study(lambda member, number=number: number * 1e-3 * spacing(member) ** 2))  # type: ignore[misc]
        tables.append(tree["schemes"].to_dataset().drop_vars("reference").expand_dims(problem=[name]))
    return xr.merge(tables, join="outer", compat="no_conflicts", combine_attrs="drop_conflicts").assign_attrs(title="Two")


def test_each_scheme_has_its_errors_costs_and_drifts() -> None:
    table = several()
    table["mass_drift"] = table["mass_drift"] + 1e-9
    table["cpu_seconds"] = table["cpu_seconds"].fillna(2.0)
    figure = schemes_overview(table)
    assert places(figure) == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)]
    for row, problem in enumerate(table["problem"].values):
        errors, costs, drifts = figure.axes[3 * row : 3 * row + 3]
        assert errors.get_title() == f"{problem}, n = 2"
        for scheme in table["scheme"].values:
            own = table.sel(problem=problem, scheme=scheme, n=2)
            for axes, across, up in ((errors, own["size"], "error"), (costs, own["cpu_seconds"], "error")):
                (line,) = [line for line in axes.lines if line.get_label() == scheme]
                np.testing.assert_array_equal(line.get_xdata(), across.values)
                np.testing.assert_array_equal(line.get_ydata(), own[up].values)
            (line,) = [line for line in drifts.lines if line.get_label() == scheme]
            np.testing.assert_array_equal(line.get_ydata(), own["mass_drift"].values)
    lines = [line for line in figure.axes[0].lines if not str(line.get_label()).startswith("_")]
    assert len({line.get_marker() for line in lines}) == len({line.get_linestyle() for line in lines}) == len(lines)


def test_the_errors_alone_stand_in_a_row_for_each_problem() -> None:
    table = several()
    figure = scheme_errors(table)
    assert places(figure) == [(0, 0), (1, 0)]
    slopes = [line for line in figure.axes[0].lines if str(line.get_label()).startswith("_")]
    found = [np.polyfit(np.log(line.get_xdata()), np.log(line.get_ydata()), 1)[0] for line in slopes]
    assert found == pytest.approx([-2, -4, -6])
    bottom, top = figure.axes[0].get_ylim()
    assert bottom < float(table["error"][0].min())
    assert top > float(table["error"][0].max())


def test_schemes_without_an_exponent_a_drift_or_an_error_are_drawn_or_refused_in_a_sentence() -> None:
    table = several().isel(problem=0, n=0, drop=True)
    assert len(schemes_overview(table).axes) == 2, "what has no drift has no panel of drifts"
    zero = table.assign(error=0 * table["error"])
    schemes_overview(zero).canvas.draw()
    with pytest.raises(InputError, match="nothing to draw"):
        schemes_overview(table.assign(error=np.nan * table["error"]))


def test_slopes_and_empty_quantities_do_not_crush_the_measured() -> None:
    """h^4 falls by 256 here and the distance by 2: the heights of the axes are those of the distance and its error bar."""
    tree = judge(study(lambda member: 1e-3 * spacing(member)))
    figure = convergence_overview(tree)
    ladder = tree["ladder"].to_dataset()
    assert figure.axes
    for axes, quantity in zip(figure.axes, ladder["quantity"].values, strict=False):
        values = ladder["distance"].sel(quantity=quantity).values
        values = values[np.isfinite(values) & (values > 0)]
        if values.size:
            bars = [float(np.asarray(line.get_ydata())[0]) for line in axes.lines if line.get_color() == "grey"]
            assert axes.get_ylim()[0] == pytest.approx(0.5 * min([*values, *bars]))
        else:
            assert [text.get_text() for text in axes.texts] == ["no distance is known"]
            assert not [line for line in axes.lines if line.get_color() == "lightgrey"]
