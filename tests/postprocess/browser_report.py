# SPDX-License-Identifier: BSD-3-Clause
"""The page of `culm report` in headless Chromium: no errors, figures with data, working controls.

Exits with 77 if Chromium, its driver, selenium or D3 is missing. Prints the time until a page is
drawn; this time has no limit.
"""
import contextlib
import importlib.util
import io
import os
import shutil
import sys
import tempfile
import time
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "postprocess")]
SKIPPED = 77
PATIENCE = 120  # seconds after which a page is taken to hang
BROWSER_OPTIONS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                   "--window-size=1250,900")


def obstacle() -> str:
    """The reason why the page cannot be tested; empty if it can."""
    modules = [name for name in ("h5py", "numpy", "selenium")
               if importlib.util.find_spec(name) is None]
    programs = [name for name in ("chromium", "chromedriver") if shutil.which(name) is None]
    if modules or programs:
        return f"{', '.join(modules + programs)} is not installed"
    from report_page.library import LibraryMissing, d3_js
    try:
        d3_js()
    except LibraryMissing as error:
        return str(error)
    return ""


def started_browser():
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
    options = Options()
    options.binary_location = shutil.which("chromium")
    for option in BROWSER_OPTIONS:
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)


def write_page(folder: Path) -> Path:
    import report
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        if report.main([str(folder)]) != 0:
            raise AssertionError("culm report failed")
    return Path(out.getvalue().strip())


class PageTest(unittest.TestCase):
    """Questions to the page in `cls.browser`; an error on its console is a fault."""

    @classmethod
    def ask(cls, expression: str, *arguments):
        return cls.browser.execute_script(f"return {expression};", *arguments)

    @classmethod
    def wait(cls, condition: str):
        deadline = time.monotonic() + PATIENCE
        while not cls.ask(condition):
            if time.monotonic() > deadline:
                raise AssertionError(f"not within {PATIENCE} s: {condition}")
            time.sleep(0.05)

    def find(self, selector: str):
        from selenium.webdriver.common.by import By
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def tearDown(self):
        errors = [entry["message"] for entry in self.browser.get_log("browser")]
        self.assertEqual(errors, [])


class BrowserTest(PageTest):
    """`self.browser` shows the page of `make(folder)`."""

    @classmethod
    def make(cls, folder: Path):
        raise NotImplementedError

    @classmethod
    def setUpClass(cls):
        place = tempfile.TemporaryDirectory()
        cls.addClassCleanup(place.cleanup)
        folder = Path(place.name) / "results"
        folder.mkdir()
        cls.make(folder)
        page = write_page(folder)
        cls.browser = started_browser()
        cls.addClassCleanup(cls.browser.quit)
        cls.browser.get(page.as_uri())
        cls.wait("document.documentElement.dataset.ready === 'true'")
        ready = cls.ask("performance.getEntriesByName('culm-ready')[0].startTime")
        print(f"{cls.__name__}: {page.stat().st_size / 1e6:.2f} MB, all drawn after "
              f"{ready:.0f} ms", flush=True)

    def point_at(self, selector: str, right: int, down: int, clicks: bool = False):
        """Moves the mouse to a position in a drawing, relative to its centre."""
        from selenium.webdriver.common.action_chains import ActionChains
        element = self.find(selector)
        self.ask("arguments[0].scrollIntoView({block: 'center'})", element)
        actions = ActionChains(self.browser).move_to_element_with_offset(element, right, down)
        (actions.click() if clicks else actions).perform()


class APageOfEverything(BrowserTest):
    @classmethod
    def make(cls, folder):
        from report_folder import write_everything
        write_everything(folder)

    def test_draws_every_figure_with_data(self):
        counts = self.ask("""Array.from(document.querySelectorAll('.drawing'), (drawing) => {
            const canvas = drawing.querySelector('canvas');
            const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
            let coloured = 0; // pixels that are neither empty nor grey: marks, not axes
            for (let k = 0; k < data.length; k += 4)
                coloured += data[k + 3] > 0 && (data[k] !== data[k + 1] || data[k] < 100);
            return [drawing.id, drawing.querySelectorAll('svg text').length, coloured];
        })""")
        self.assertGreater(len(counts), 25)
        for name, labels, coloured in counts:
            self.assertGreater(labels, 2, name)
            self.assertGreater(coloured, 40, name)

    def test_zooms_by_dragging_and_back_by_double_click(self):
        from selenium.webdriver.common.action_chains import ActionChains
        svg = self.find("#study-design svg")
        view = "document.getElementById('study-design').figure.x.view"
        self.ask("arguments[0].scrollIntoView({block: 'center'})", svg)
        whole = self.ask(view)
        (ActionChains(self.browser).move_to_element_with_offset(svg, -40, -40).click_and_hold()
         .move_by_offset(80, 60).release().perform())
        low, high = self.ask(view)
        self.assertGreater(low, whole[0])
        self.assertLess(high, whole[1])
        ActionChains(self.browser).double_click(svg).perform()
        self.assertEqual(self.ask(view), whole)
        self.ask("document.querySelector('#study-design .tools button').click()")
        self.assertLess(self.ask(f"{view}[1]"), whole[1])
        self.ask("document.querySelector('#study-design .tools button:last-child').click()")
        self.assertEqual(self.ask(view), whole)

    def test_legend_hides_a_trace(self):
        button = self.find("#study-residuals-bond_damping .traces button")
        hidden = "document.getElementById('study-residuals-bond_damping').figure.marks[0].hidden"
        button.click()
        self.assertTrue(self.ask(hidden))
        self.assertEqual(button.get_attribute("aria-pressed"), "false")
        button.click()
        self.assertFalse(self.ask(hidden))

    def test_runs_nothing_that_files_say(self):
        self.assertIsNone(self.ask("window.injected"))
        self.assertEqual(self.ask("document.querySelectorAll('[onmouseover]').length"), 0)

    def test_loads_nothing(self):
        self.assertEqual(self.ask("performance.getEntriesByType('resource').length"), 0)

    def test_describes_a_point_on_hover(self):
        place = self.ask("""(() => {
            const drawing = document.getElementById('study-regression-bond_damping');
            drawing.scrollIntoView({block: 'center'});
            const box = drawing.getBoundingClientRect();
            const [x, y] = drawing.figure.pixelOf(0, 0);
            return [x - (box.left + box.right) / 2, y - (box.top + box.bottom) / 2];
        })()""")
        self.point_at("#study-regression-bond_damping", *map(round, place))
        self.wait("document.querySelector('#study-regression-bond_damping .ring') !== null")
        text = self.find("#study-regression-bond_damping .hint").text
        self.assertRegex(text, r"point \d+")
        self.assertIn("GPa", text)

    def test_picks_a_point_by_mouse_by_list_and_by_arrows(self):
        facts = self.find(".picker .facts")
        self.assertIn("bond_damping = 25,", facts.text)
        place = self.ask("""(() => {
            const drawing = document.getElementById('study-design');
            drawing.scrollIntoView({block: 'center'});
            const box = drawing.getBoundingClientRect();
            const [x, y] = drawing.figure.pixelOf(0, drawing.figure.data[0].x.length - 1);
            return [x - (box.left + box.right) / 2, y - (box.top + box.bottom) / 2];
        })()""")
        before = self.ask("document.getElementById('study-history').figure.data[0].y.slice(0, 40)")
        self.point_at("#study-design", *map(round, place), clicks=True)
        self.wait("document.querySelector('.picker select').value === '11'")
        self.assertIn("bond_damping = 200", facts.text)
        self.assertNotEqual(
            before, self.ask("document.getElementById('study-history').figure.data[0].y.slice(0, 40)"))
        self.find(".picker .next").click()
        self.assertEqual(self.ask("document.querySelector('.picker select').value"), "0")
        self.find(".picker .previous").click()
        self.assertEqual(self.ask("document.querySelector('.picker select').value"), "11")
        self.find(".picker select").send_keys("5")
        self.wait("document.querySelector('.picker select').value === '5'")
        self.assertIn("bond_damping = 100", facts.text)

    def test_history_is_near_its_fit(self):
        simulated, fitted = self.ask(
            "document.getElementById('study-history').figure.data.map((trace) => trace.y)")
        # The synthetic tips follow Eq. 1 except for the rounding of 15 mm to 16 bits.
        for a, b in zip(simulated, fitted):
            self.assertAlmostEqual(a, b, delta=0.01)

    def test_moves_the_stem_by_slider_and_by_play(self):
        drawing = "document.getElementById('comparison-stem-all').figure"
        self.ask("(() => { const s = document.querySelector('#comparison .moment'); s.value = 30;"
                 "s.dispatchEvent(new Event('input')); })()")
        self.assertIn("t = 145.0 ms", self.find("#comparison .animation .facts").text)
        dots = self.ask(f"{drawing}.data[1].x")
        line = self.ask(f"{drawing}.data[0].x")
        self.assertEqual((len(dots), len(line)), (3, 4))
        self.assertEqual(line[0], 0)
        for seen, modelled in zip(dots, line[1:]):
            self.assertAlmostEqual(seen, modelled, delta=0.05)
        self.find("#comparison .play").click()
        self.wait(f"{drawing}.data[1].x[2] !== {dots[2]}")
        self.assertEqual(self.find("#comparison .play").text, "Pause")
        self.find("#comparison .play").click()
        self.assertEqual(self.find("#comparison .play").text, "Play")

    def test_is_reached_by_the_keyboard(self):
        from selenium.webdriver.common.keys import Keys
        body = self.find("body")
        self.ask("document.activeElement.blur()")
        reached = set()
        for _ in range(60):
            self.browser.switch_to.active_element.send_keys(Keys.TAB)
            reached.add(self.ask("document.activeElement.className || "
                                 "document.activeElement.tagName"))
        self.assertTrue({"skip", "previous", "next", "SELECT", "SUMMARY"} <= reached, reached)
        self.assertIsNotNone(body)

    def test_fits_a_narrow_window(self):
        self.addCleanup(self.browser.set_window_size, 1250, 900)
        self.browser.set_window_size(520, 900)
        time.sleep(1.0)  # drawings follow the window a moment later
        self.assertLessEqual(self.ask("document.documentElement.scrollWidth"),
                             self.ask("window.innerWidth"))


class TenThousandPoints(BrowserTest):
    @classmethod
    def make(cls, folder):
        import numpy as np
        from synthetic_study import Synthetic
        Synthetic(dampings=tuple(np.linspace(25, 200, 100)),
                  moduli_gpa=tuple(np.linspace(1, 10, 100)), store="tip").write(folder)

    def test_can_all_be_hovered_and_clicked(self):
        self.point_at("#study-design", 0, 0)
        self.wait("document.querySelector('#study-design .hint').style.display === 'block'")
        self.assertIn("b2, Hz:", self.find("#study-design .hint").text)
        before = self.find(".picker .facts").text
        self.point_at("#study-design", 0, 0, clicks=True)
        self.wait("document.querySelector('.picker select').value !== '0'")
        self.assertNotEqual(self.find(".picker .facts").text, before)


if __name__ == "__main__":
    reason = obstacle()
    if reason:
        print(f"skipped: {reason}")
        sys.exit(SKIPPED)
    os.environ.setdefault("SE_AVOID_STATS", "true")
    unittest.main()
