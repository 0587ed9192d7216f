"""How settings and studies look in a notebook and in a line."""

from __future__ import annotations

from dataclasses import dataclass, replace
from html.parser import HTMLParser

import numpy as np
import pytest

from mol_compactons import Compacton, ConservativeScheme, Family, Formula, Grid, Samples, converge, report
from mol_compactons.configuration import Settings
from mol_compactons.notebook import html_of_tables, short
from tests.systems import one_compacton


class Text(HTMLParser):
    """The words of a page, and the tags that it is made of."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.words: list[str] = []
        self.tags: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def test_a_simulation_shows_its_parts_and_nothing_that_is_executed() -> None:
    simulation = replace(one_compacton(), title="<script>alert(1)</script> & more")
    page = Text(simulation._repr_html_())
    assert "script" not in page.tags
    assert any(word.startswith("<script>alert(1)</script> & more: ") for word in page.words)
    assert "equation: GranularCompacton" in page.words
    assert page.words[page.words.index("t_end") + 1] == repr(simulation.t_end)
    assert page.tags.count("details") == 1 + len(("equation", "grid", "initial", "scheme", "integrator"))


def test_what_is_a_default_is_fainter() -> None:
    page = ConservativeScheme(order=6)._repr_html_()
    assert "<tr><td>order</td><td>6</td></tr>" in page
    assert '<tr class="default"><td>viscosity_order</td>' in page


def test_long_lists_are_short_in_both() -> None:
    samples = Samples(tuple(np.cos(np.arange(5000) / 100).tolist()))
    assert len(repr(samples)) < 300
    assert "5000 values" in repr(samples)
    assert len(samples._repr_html_()) < 3000
    simulation = replace(one_compacton(t_end=1), output_times=np.linspace(0, 1, 1001).tolist())
    assert "1001 values" in repr(simulation)


@pytest.mark.parametrize("part", [Grid(30, 75), Compacton(1, 5), ConservativeScheme(order=6), Formula("sin(x)")])
def test_a_short_repr_is_python(part: Settings) -> None:
    names = {kind.__name__: kind for kind in (Grid, Compacton, ConservativeScheme, Formula)}
    assert eval(repr(part), names) == part


def test_a_repr_of_ones_own_stays() -> None:
    @dataclass(frozen=True)
    class Own(Settings):
        number: float = 1.0

        def __repr__(self) -> str:
            return "mine"

    assert repr(Own()) == "mine"


def test_lists_up_to_eight_are_whole() -> None:
    assert short(tuple(range(8))) == "(0, 1, 2, 3, 4, 5, 6, 7)"
    assert short(tuple(range(9))) == "(0, 1, ..., 8; 9 values)"


def test_a_table_has_headings_for_a_screen_reader() -> None:
    page = html_of_tables([("a < b", ["one", "two"], [["1", "<2>"]])], ["after"])
    assert "<caption>a &lt; b</caption>" in page
    assert '<th scope="col">one</th>' in page
    assert "<td>&lt;2&gt;</td>" in page
    assert "<div>after</div>" in page


def test_a_study_shows_its_verdicts() -> None:
    study = converge(one_compacton(t_end=0.3, frames=4), Family(sizes=(75, 150)))
    told = report(study)
    assert str(told) == "\n".join(told)
    page = Text(told._repr_html_())
    assert page.tags.count("table") == study["summary"].sizes["limit"]
    for name in study["summary"].to_dataset()["quantity"].values:
        assert str(name) in page.words
