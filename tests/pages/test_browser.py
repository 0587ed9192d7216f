"""The pages in a browser: nothing complains, nothing is asked of a network, and what can be touched works."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

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

    def __init__(self, browser: Any, path: Path, size: dict[str, int], scheme: str) -> None:
        self.context = browser.new_context(viewport=size, color_scheme=scheme)
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
@pytest.mark.parametrize(("size", "scheme"), [(DESKTOP, "light"), (PHONE, "dark")], ids=["desktop, light", "phone, dark"])
def test_a_page_of_each_kind_is_sound(browser: Any, pages: dict[str, Path], kind: str, size: Any, scheme: str) -> None:
    visit = Visit(browser, pages[kind], size, scheme)
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


def test_a_picture_takes_the_colours_of_the_night(browser: Any, pages: dict[str, Path]) -> None:
    visit = Visit(browser, pages["run"], DESKTOP, "light")
    colour = "document.getElementById('profile').layout.font.color"
    before = visit.page.evaluate(colour)
    visit.page.emulate_media(color_scheme="dark")
    visit.wait_until(f"{colour} !== '{before}'")
    visit.context.close()
