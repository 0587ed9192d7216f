"""The pages in a browser: nothing complains, nothing is asked of a network, and what can be touched works."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mol_compactons import write_report

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed")

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium; Debian's package of that name brings it")

ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]

KINDS = ("run", "chain", "study", "sweep")

DESKTOP, PHONE = {"width": 1200, "height": 900}, {"width": 360, "height": 740}


@pytest.fixture(scope="module")
def pages(
    pair: xr.Dataset,
    chain: tuple[xr.Dataset, xr.Dataset],
    study: xr.DataTree,
    swept: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> dict[str, Path]:
    """A page of each kind."""
    folder = tmp_path_factory.mktemp("pages")
    sources: dict[str, Any] = {"run": pair, "chain": chain[0], "study": study, "sweep": swept}
    return {
        kind: write_report(sources[kind], folder / f"{kind}.html", continuum=chain[1] if kind == "chain" else None)
        for kind in KINDS
    }


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


class Visit:
    """A page that is open, and what went wrong in it."""

    def __init__(self, browser: Any, path: Path, size: dict[str, int], scheme: str, **more: bool) -> None:
        self.context = browser.new_context(viewport=size, color_scheme=scheme, **more)
        self.page = self.context.new_page()
        self.faults: list[str] = []
        self.page.on("console", lambda said: self.faults.append(said.text) if said.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("request", lambda asked: self.note(asked.url))
        self.page.on("dialog", lambda dialog: self.faults.append(f"dialog: {dialog.message}"))
        self.page.goto(path.as_uri())
        self.page.wait_for_selector("body[data-ready]", timeout=60_000)

    def note(self, url: str) -> None:
        if not url.startswith(("file:", "data:", "blob:")):
            self.faults.append(f"asked for {url}")

    def wait_until(self, condition: str) -> None:
        """Until an expression holds; what Playwright has for that is forbidden by the policy of the page."""
        for _ in range(200):
            if self.page.evaluate(condition):
                return
            self.page.wait_for_timeout(50)
        pytest.fail(f"never: {condition}")

    def height_at(self, frame: int) -> float:
        """The largest value of the profile, which stands at a frame."""
        assert self.page.input_value("#time") == str(frame)
        return float(self.page.evaluate("Math.max(...document.getElementById('profile').data[0].y)"))


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_of_each_kind_is_sound_on_a_desk_by_day_and_on_a_phone_by_night(
    browser: Any, pages: dict[str, Path], kind: str
) -> None:
    visit = Visit(browser, pages[kind], DESKTOP, "light")
    for size, scheme in ((DESKTOP, "light"), (PHONE, "dark")):
        visit.page.set_viewport_size(size)
        visit.page.emulate_media(color_scheme=scheme)
        found = axe.Axe().run(visit.page).response["violations"]
        assert [(one["id"], one["nodes"][0]["html"]) for one in found if one["impact"] in ("serious", "critical")] == []
        assert visit.page.evaluate("document.documentElement.scrollWidth <= innerWidth"), "it is not wider than the screen"
    assert visit.page.locator("figure .main-svg").count() > 0
    for select in visit.page.locator("select").all():
        for option in select.locator("option").all_inner_texts()[:3]:
            select.select_option(option)
    assert visit.faults == []
    visit.context.close()


def test_play_slider_keyboard_hover_and_click(browser: Any, pages: dict[str, Path], pair: xr.Dataset) -> None:
    visit = Visit(browser, pages["run"], DESKTOP, "light")
    page, last = visit.page, pair.sizes["t"] - 1
    heights = pair.W.max("x").values
    assert visit.height_at(0) == pytest.approx(heights[0], rel=1e-6)

    page.focus("#time")
    page.keyboard.press("ArrowRight")
    assert visit.height_at(1) == pytest.approx(heights[1], rel=1e-6)
    page.keyboard.press("End")
    assert visit.height_at(last) == pytest.approx(heights[last], rel=1e-6)
    assert page.inner_text("#now") == "t = 28"
    assert page.get_attribute("#time", "aria-valuetext") == "t = 28"

    marker = page.evaluate("(({y0, y1}) => [y0, y1])(document.getElementById('map').layout.shapes[0])")
    assert marker == [28, 28], "a line on the map stands at the time of the profile"
    assert page.evaluate("document.getElementById('map').layout.shapes.length") == 1

    page.focus("#play")
    page.keyboard.press("Space")
    visit.wait_until("document.getElementById('time').value > 2")
    assert page.get_attribute("#play", "aria-label") == "Pause the run"
    page.keyboard.press("Space")
    frame = int(page.input_value("#time"))
    assert 2 < frame < last
    page.wait_for_timeout(200)
    assert visit.height_at(frame) == pytest.approx(heights[frame], rel=1e-6)

    page.locator("#map").scroll_into_view_if_needed()
    place = page.locator("#map .nsewdrag").bounding_box()
    page.mouse.move(place["x"] + place["width"] / 2, place["y"] + place["height"] * 0.75)
    page.wait_for_selector("#map .hovertext")
    told = page.locator("#map .hovertext").text_content()
    assert "W = " in told
    assert "t = 7" in told
    page.mouse.click(place["x"] + place["width"] / 2, place["y"] + place["height"] * 0.75)
    visit.wait_until("document.getElementById('now').textContent === 't = 7'")
    assert visit.height_at(14) == pytest.approx(heights[14], rel=1e-6)
    assert visit.faults == []
    visit.context.close()


def test_pictures_take_the_colours_of_the_night(browser: Any, pages: dict[str, Path]) -> None:
    visit = Visit(browser, pages["run"], DESKTOP, "light")
    ink, zero = (
        "document.getElementById('profile').layout.font.color",
        "document.getElementById('map').data[0].colorscale[2][1]",
    )
    before = visit.page.evaluate(ink)
    assert visit.page.evaluate(zero) == "#f7f7f7"
    visit.page.emulate_media(color_scheme="dark")
    visit.wait_until(f"{ink} !== '{before}'")
    assert (
        visit.page.evaluate(zero) == visit.page.evaluate("getComputedStyle(document.body).getPropertyValue('--paper')").strip()
    )
    assert visit.faults == []
    visit.context.close()


def test_the_members_of_a_sweep_are_sorted_by_keyboard(browser: Any, pages: dict[str, Path]) -> None:
    visit = Visit(browser, pages["sweep"], DESKTOP, "light")
    table = visit.page.locator("table:has(thead button)")
    heading = table.locator("th[scope=col]", has_text="viscosity")
    number = heading.evaluate("heading => heading.cellIndex")
    column = f"rows => rows.map((row) => row.cells[{number}].textContent)"
    before = table.locator("tbody tr").evaluate_all(column)
    heading.locator("button").focus()
    for word, backwards in (("ascending", False), ("descending", True)):
        visit.page.keyboard.press("Enter")
        assert heading.get_attribute("aria-sort") == word
        found = table.locator("tbody tr").evaluate_all(column)
        assert [float(one) for one in found] == sorted(map(float, before), reverse=backwards)
    assert table.locator("[aria-sort]").count() == 1
    assert visit.faults == []
    visit.context.close()


def test_a_run_with_gaps_and_a_finger(browser: Any, pair: xr.Dataset, tmp_path: Path) -> None:
    """What is no number is a gap in the profile; a finger scrolls the page, and chooses a time by a tap."""
    torn = pair.copy(deep=True)
    torn.W[:, 30:40] = np.nan
    path = write_report(torn, tmp_path / "torn.html")
    visit = Visit(browser, path, PHONE, "dark", has_touch=True, is_mobile=True)
    assert visit.page.evaluate("Array.from(document.getElementById('profile').data[0].y).filter(Number.isNaN).length") == 10
    assert visit.page.evaluate("document.getElementById('map').layout.dragmode") is False
    visit.page.locator("#map").scroll_into_view_if_needed()
    place = visit.page.locator("#map .nsewdrag").bounding_box()
    visit.page.touchscreen.tap(place["x"] + place["width"] * 0.8, place["y"] + place["height"] / 2)
    visit.wait_until("document.getElementById('now').textContent === 't = 14'")
    assert visit.faults == []
    visit.context.close()
