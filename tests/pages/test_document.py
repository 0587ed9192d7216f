from __future__ import annotations

import base64
import hashlib
import json
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from markupsafe import escape

from mol_compactons.pages.document import Moving, Page, Section, Table, as_data, look_of, policy_for, rendered
from mol_compactons.pages.plots import figure


@given(st.recursive(st.text() | st.floats(allow_nan=False), lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner)))
def test_data_come_back_and_never_end_their_element(content: object) -> None:
    text = as_data(content)
    assert "<" not in text
    assert json.loads(text) == content


@given(st.lists(st.text(), min_size=2, max_size=3))
def test_what_is_shown_is_text(words: list[str]) -> None:
    table = Table("c", words, [words])
    page = rendered(Page(words[0], "complete", words, [Section("a", "b", words, tables=[table])]))
    assert page.count("<script") == 4, "none but those of the page"
    for word in words[1:]:
        assert f'<td class="{look_of(word)}">{escape(word)}</td>' in page


def test_only_the_scripts_of_the_page_may_run() -> None:
    page = rendered(Page("a", "complete", [], []))
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)
    assert policy
    allowed = set(re.findall(r"sha256-([^&]+)&#39;", policy[1]))
    scripts = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    found = {base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts}
    assert found == allowed
    assert len(found) == 2
    assert "default-src 'none'" in policy_for([])


def test_the_field_is_there_once_as_floats() -> None:
    rng = np.random.default_rng(3)
    series = [("a", np.arange(7.0), rng.normal(size=(5, 7))), ("b", np.arange(3.0), rng.normal(size=(5, 3)))]
    moving = Moving("W", "x", np.arange(5.0), series, figure("x", "W"), figure("x", "t"), "")
    numbers = np.frombuffer(base64.b64decode(moving.encoded), "<f4")
    for place, (_, points, values) in zip(moving.places, series, strict=True):
        assert place["points"] == points.size
        part = numbers[place["start"] : place["start"] + values.size].reshape(values.shape)
        np.testing.assert_array_equal(part, values.astype("f4"))


@pytest.mark.parametrize(("cell", "look"), [("agrees", "well short"), ("not converged", "ill short"), ("x" * 25, "long")])
def test_the_look_of_a_cell(cell: str, look: str) -> None:
    assert look_of(cell) == look
