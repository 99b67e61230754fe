"""Pages in Debian's Chromium: errors, sorting, filtering, hovering, keyboard, contrast, narrow screens, dark mode."""

import shutil

import pytest

from .pages import page_of

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")

pytestmark = [
    pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="no browser: install chromium and chromium-driver"),
    pytest.mark.xdist_group("browser"),
]

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
)  # fmt: skip

CONTRAST = """
const channel = (c) => { c /= 255; return c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; };
const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
const colour = (text) => {
  canvas.clearRect(0, 0, 1, 1); canvas.fillStyle = text; canvas.fillRect(0, 0, 1, 1);
  return [...canvas.getImageData(0, 0, 1, 1).data];
};
const behind = (element) => {
  for (let own = element; own; own = own.parentElement) {
    const found = colour(getComputedStyle(own).backgroundColor);
    if (found[3] === 255) return found;
  }
  return [255, 255, 255];
};
const faint = [];
for (const element of document.querySelectorAll("body *")) {
  const own = [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
  if (!own || !element.checkVisibility() || element.closest("script, math, [disabled]")) continue;
  const [a, b] = [light(colour(getComputedStyle(element).color)), light(behind(element))];
  const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  if (ratio < 4.5) faint.push([element.tagName, element.className, element.textContent.slice(0, 30), ratio]);
}
return faint;
"""


class Browser:
    """One Chromium for all tests of the file; `open` shows a page as a window of a size."""

    def __init__(self, folder):
        from selenium import webdriver

        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for flag in (*FLAGS, f"--user-data-dir={folder}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))

    def open(self, path, width=1280, height=1000, **features):
        told = {"prefers-reduced-motion": "reduce", "prefers-color-scheme": "light", **features}
        media = [{"name": name, "value": value} for name, value in told.items()]
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": media})
        self.driver.get(path.as_uri())
        self.wait("return document.readyState === 'complete'")
        return self

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def wait(self, script, *arguments):
        from selenium.webdriver.support.wait import WebDriverWait

        return WebDriverWait(self.driver, 60).until(lambda driver: driver.execute_script(script, *arguments))

    def all(self, selector):
        return self.driver.find_elements("css selector", selector)

    def one(self, selector):
        return self.driver.find_element("css selector", selector)

    def texts(self, selector):
        return self.run("return [...document.querySelectorAll(arguments[0])].map((e) => e.textContent)", selector)

    def errors(self):
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def draw_all(self):
        """Go through the page; stay at each curve until it is drawn, however late that is."""
        for figure in self.all("figure[data-chart]"):
            self.run("arguments[0].scrollIntoView()", figure)
            self.wait("return arguments[0].querySelector('canvas, p') !== null", figure)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    browser = Browser(tmp_path_factory.mktemp("chromium"))
    yield browser
    browser.driver.quit()


@pytest.fixture(scope="module")
def pages(tmp_path_factory, solved, request):
    """name -> its page, each written once."""
    place = tmp_path_factory.mktemp("pages")

    def page(name):
        target = place / f"{name}.html"
        if not target.exists():
            source = request.getfixturevalue("swept") if name == "swept" else solved(name)
            page_of(source, target, "--no-verify")
        return target

    return page


@pytest.mark.parametrize("name", ["cartpole", "unsolved", "phases", "branches", "experiments", "hostile", "swept"])
@pytest.mark.parametrize("width", [1280, 390])
def test_a_page_is_drawn_without_errors_and_without_scrolling_sideways(browser, pages, name, width):
    browser.open(pages(name), width)
    browser.draw_all()
    assert browser.errors() == []
    assert browser.run("return document.documentElement.scrollWidth") <= width
    inked = """
      return [...document.querySelectorAll("canvas")].map((canvas) => {
        const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
        return pixels.some((value, i) => i % 4 === 3 && value > 0);
      });"""
    drawn = browser.run(inked)
    assert drawn and all(drawn)


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", ["unsolved", "swept"])
def test_every_text_has_the_contrast_of_aa(browser, pages, name, scheme):
    browser.open(pages(name), **{"prefers-color-scheme": scheme})
    if name == "swept":
        browser.one("#table button.case").click()
    assert browser.run(CONTRAST) == []
    dark = browser.run("return getComputedStyle(document.body).backgroundColor")
    assert (dark == "rgb(255, 255, 255)") == (scheme == "light")


def test_the_contrast_is_measured(browser, pages):
    browser.open(pages("unsolved"))
    browser.run("document.querySelector('h1').style.color = '#909090'")
    assert [tag for tag, *_ in browser.run(CONTRAST)] == ["H1"]


def test_hovering_tells_the_value_on_all_curves(browser, pages):
    from selenium.webdriver import ActionChains

    browser.open(pages("cartpole"))
    browser.draw_all()
    figure = browser.one('figure[data-chart="control-0"] .u-over')
    ActionChains(browser.driver).move_to_element(figure).perform()
    for name in ("control-0", "state-0"):
        time, value, *_ = browser.texts(f'figure[data-chart="{name}"] .u-value')
        assert float(time) == pytest.approx(1, abs=0.05)
        assert float(value.replace("\N{MINUS SIGN}", "-"))


def test_zooming_one_curve_zooms_all_over_time(browser, pages):
    from selenium.webdriver import ActionChains

    browser.open(pages("cartpole"))
    browser.draw_all()
    over = browser.one('figure[data-chart="state-0"] .u-over')
    ActionChains(browser.driver).move_to_element(over).click_and_hold().move_by_offset(80, 0).release().perform()
    ranges = (
        "return Charts.drawn.filter((own) => own.chart.x.sync).map(({ plot }) => plot.scales.x.max - plot.scales.x.min)"
    )
    zoomed = browser.run(ranges)
    assert max(zoomed) < 1 and max(zoomed) == pytest.approx(min(zoomed))
    browser.one('figure[data-chart="control-0"] button.reset').click()
    assert browser.run(ranges) == pytest.approx([2] * len(zoomed))


def test_the_keyboard_does_what_the_mouse_does(browser, pages):
    from selenium.webdriver.common.keys import Keys

    browser.open(pages("cartpole"))
    figure = browser.one('figure[data-chart="state-0"]')
    browser.run("arguments[0].scrollIntoView()", figure)
    browser.wait("return document.querySelector('figure[data-chart=\"state-0\"]').tabIndex === 0")
    assert "q1 over time [s]" in figure.get_attribute("aria-label")
    figure.send_keys(Keys.ARROW_RIGHT * 5)
    first = browser.texts('figure[data-chart="state-0"] .u-value')
    figure.send_keys(Keys.ARROW_RIGHT)
    assert float(browser.texts('figure[data-chart="state-0"] .u-value')[0]) > float(first[0])
    span = "const x = Charts.drawn.find((own) => own.chart.title === 'q1').plot.scales.x; return x.max - x.min"
    figure.send_keys("+++")
    assert browser.run(span) < 1.5
    figure.send_keys("0")
    assert browser.run(span) == pytest.approx(2)
    legend = browser.one('figure[data-chart="state-0"] .u-series:nth-child(2) th')
    legend.send_keys(Keys.ENTER)
    assert "u-off" in browser.one('figure[data-chart="state-0"] .u-series:nth-child(2)').get_attribute("class")


PLAYED = """
const play = document.getElementById('play'), moment = document.getElementById('moment');
return new Promise((done) => {
  const look = () => { if (Number(moment.value) > 3) { play.click(); done(); } else setTimeout(look, 5); };
  play.click(); look();
})"""
"""The film played until its third picture and stopped: in the page itself, as no film waits for this process."""


def test_nothing_moves_until_it_is_asked_to(browser, pages):
    browser.open(pages("cartpole"))
    shapes = "return document.querySelector('#film svg').innerHTML"
    before = browser.run(shapes)
    browser.run("return new Promise((done) => setTimeout(done, 200))")
    assert browser.run(shapes) == before and browser.one("#play").text == "Play"
    browser.run(PLAYED)
    assert browser.run(shapes) != before and browser.one("#play").text == "Play"
    assert browser.run("return getComputedStyle(document.documentElement).scrollBehavior") == "auto"


def test_a_name_that_looks_like_a_script_is_text(browser, pages):
    browser.open(pages("hostile"))
    browser.draw_all()
    assert browser.one("h1").text == '<script>alert(1)</script> & "quoted"'
    assert browser.errors() == []
    browser.run("const s = document.createElement('script'); s.textContent = 'window.ran = 1'; document.body.append(s)")
    assert browser.run("return window.ran") is None  # what is not trajopt's own does not run
    assert len(browser.errors()) == 1


def rows(browser):
    """The rows of the table of cases that are shown: column -> text."""
    return browser.run("""
      const names = [...document.querySelectorAll("#table thead th")].map((th) => th.dataset.column);
      return [...document.querySelectorAll("#table tbody tr")].map((row) =>
        Object.fromEntries([...row.cells].map((cell, i) => [names[i], cell.textContent])));""")


def numbers(browser, name):
    return [float(row[name].replace("\N{MINUS SIGN}", "-")) for row in rows(browser) if row[name] != "–"]


def test_cases_are_sorted(browser, pages):
    browser.open(pages("swept"))
    head = '#table th[data-column="objective"]'
    browser.one(f"{head} button").click()
    rising = numbers(browser, "objective")
    assert rising == sorted(rising) and browser.one(head).get_attribute("aria-sort") == "ascending"
    browser.one(f"{head} button").click()
    assert numbers(browser, "objective") == rising[::-1]
    assert browser.one(head).get_attribute("aria-sort") == "descending"
    browser.one('#table th[data-column="status"] button').click()
    shown = [row["status"] for row in rows(browser)]
    assert shown == sorted(shown)


@pytest.mark.parametrize(
    ("column", "asked", "cases"),
    [
        ("controls.u.upper", ">=8", [8, 9, 10, 11]),
        ("controls.u.upper", "4.5..5", [2, 3, 4, 5]),
        ("controls.u.upper", "5", [4, 5]),
        ("mesh.0.segments", "< 8", [0, 2, 4, 6, 8, 10]),
        ("status", "SOLV", list(range(2, 12))),
        ("status", "nothing", []),
    ],
)
def test_cases_are_filtered(browser, pages, column, asked, cases):
    browser.open(pages("swept"))
    browser.one(f'[data-filter="{column}"]').send_keys(asked)
    assert numbers(browser, "case") == cases
    assert browser.one("#count").text == f"{len(cases)} of 12 cases"
    browser.one("#clear").click()
    assert numbers(browser, "case") == list(range(12))


def test_a_case_is_shown_when_it_is_chosen(browser, pages):
    from selenium.webdriver.common.keys import Keys

    browser.open(pages("swept"))
    browser.one("#table tbody tr:nth-child(6) button.case").send_keys(Keys.ENTER)
    assert browser.one("#case h2").text == "Case 5: controls.u.upper = 5, mesh.0.segments = 8"
    assert browser.texts("#case .chart .title") == ["x", "v", "u"] and len(browser.all("#case canvas")) == 3
    assert browser.driver.switch_to.active_element.text.startswith("Case 5")
    failed = browser.one("#map button.failed-case")
    failed.click()
    assert browser.one("#case h2").text.startswith("Case 0: controls.u.upper = 0.5")
    assert "contradict" in browser.one("#case .facts").text and not browser.all("#case canvas")
    assert "No curves are kept" in browser.one("#case").text
    assert browser.errors() == []


def test_the_outcome_is_drawn_over_what_was_swept(browser, pages):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.support.select import Select

    browser.open(pages("swept"))
    assert len(browser.all("#map tbody button")) == 12 and len(browser.all("#map .failed-case")) == 2
    assert browser.texts("#over .u-label")[1:] == ["segments = 4", "segments = 8"]
    Select(browser.one("#quantity")).select_by_value("iterations")
    assert browser.one("#over .title").text.startswith("iterations")
    Select(browser.one("#across")).select_by_visible_text("mesh.0.segments")
    assert browser.texts("#over .u-label")[0] == "mesh.0.segments"
    ActionChains(browser.driver).move_to_element_with_offset(browser.one("#over .u-over"), 300, 0).click().perform()
    assert "mesh.0.segments = 8" in browser.one("#case h2").text
    assert browser.errors() == []
