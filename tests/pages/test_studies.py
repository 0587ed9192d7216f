from __future__ import annotations

import numpy as np
import xarray as xr

from mol_compactons import report
from mol_compactons.pages.document import rendered
from mol_compactons.pages.studies import page_of_study


def test_it_has_the_verdicts_the_budget_and_the_ladder(study: xr.DataTree) -> None:
    page = page_of_study(study)
    summary, ladder = study["summary"].to_dataset(), study["ladder"].to_dataset()
    parts = {section.name: section for section in page.sections}
    for table, limit in zip(parts["verdicts"].tables, summary["limit"].values, strict=True):
        assert [row[5] for row in table.rows] == summary["verdict"].sel(limit=limit).values.tolist()
    for picture, limit in zip(parts["budget"].pictures, summary["limit"].values, strict=True):
        whole = (summary["error"] / summary["scale"]).sel(limit=limit).values
        drawn = np.array([np.nan if one is None else one for one in picture.figure.data[0].x], dtype=float)
        np.testing.assert_allclose(drawn, np.where((whole > 0) & np.isfinite(whole), whole, np.nan))
    (picture,) = parts["ladder"].pictures
    assert picture.choices
    assert set(picture.choices) <= set(ladder["quantity"].values.tolist())
    assert sorted(place for places in picture.choices.values() for place in places) == list(range(len(picture.figure.data)))
    seen = [number for number, one in enumerate(picture.figure.data) if one.visible]
    assert seen == next(iter(picture.choices.values()))
    assert parts["words"].code == str(report(study))


def test_the_status_is_the_worst_verdict(study: xr.DataTree) -> None:
    verdicts = set(study["summary"].to_dataset()["verdict"].values.ravel().tolist())
    worst = next(word for word in ("not converged", "converging", "converged") if word in verdicts)
    assert page_of_study(study).status == worst
    assert f">{worst}</p>" in rendered(page_of_study(study))
