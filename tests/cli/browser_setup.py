# SPDX-License-Identifier: BSD-3-Clause
"""The page of `culm setup` in headless Chromium: with a sample in place of what the program detects,
and from a drawn video to its measurement.

Exits with 77 if Chromium, its driver, selenium, numpy or PIL is missing. With CULM_SCREENSHOTS set
to a folder, pictures of the page are written there.
"""
import base64
import copy
import importlib.util
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "postprocess"), str(HERE.parent / "support"),
                str(HERE.parents[1] / "postprocess")]
from browser_report import PATIENCE, PageTest, started_browser  # noqa: E402

PROGRAM = os.environ["CULM_PROGRAM"]
SKIPPED = 77
WIDE = (1280, 1000)
NARROW = (420, 900)
WIDTH, HEIGHT = 480, 320
CLAMP, TIP = (42.0, 171.4), (432.0, 163.2)


def obstacle() -> str:
    """The reason why the page cannot be tested; empty if it can."""
    modules = [name for name in ("numpy", "PIL", "selenium")
               if importlib.util.find_spec(name) is None]
    programs = [name for name in ("chromium", "chromedriver") if shutil.which(name) is None]
    return f"{', '.join(modules + programs)} is not installed" if modules or programs else ""


def axis_of(bend: float) -> list:
    """The axis of a stem whose tip is deflected by `bend` pixels."""
    parts = [k / 30 for k in range(31)]
    return [[round(CLAMP[0] + (TIP[0] - CLAMP[0]) * s, 2),
             round(CLAMP[1] + (TIP[1] - CLAMP[1]) * s + bend * s * s * (3 - s) / 2, 2)] for s in parts]


def drawn(axis: list) -> str:
    """A dark stem on a bright background with uneven light, as a data URL."""
    import numpy as np
    from PIL import Image
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    light = 150 + 70 * np.exp(-((columns - 330) / 190) ** 2 - ((rows - 110) / 150) ** 2)
    x, y = np.array(axis).T
    distance = np.abs(rows - np.interp(columns, x, y))
    inside = (distance < 3.6) & (columns >= x[0]) & (columns <= x[-1])
    light = np.where(inside, 0.3 * light, light)
    light[120:230, :int(CLAMP[0])] = 60  # the clamp
    light += np.random.default_rng(1).normal(0, 4, light.shape)
    tints = np.array([1.0, 0.97, 0.75])
    pixels = np.clip(light[..., None] * tints, 0, 255).astype(np.uint8)
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG", quality=85)
    return "data:image/jpeg;base64," + base64.b64encode(file.getvalue()).decode()


def sample() -> dict:
    bends = {57: 41, 58: 36, 60: 12, 63: -30, 66: -8, 69: 24, 399: 0}
    captions = {57: "held, the last frame before the release", 399: "at rest"}
    def limits(low, high, is_open=True):
        return {"from": low, "to": high, "open": is_open}
    return {
        "program": "culm 0.9", "video": "swing.mp4", "frames_key": 'a "b"/swing.mp4',
        "folder": "results/video", "bands": 3,
        "command": "culm track results/video/video.toml -o results/video/measurement",
        "frame_width": WIDTH, "frame_height": HEIGHT, "frame_count": 400, "first_number": 0,
        "last_number": 399, "stated_fps": 30.0, "rate_is_the_cameras": False,
        "detected": {"up": "increasing_column", "clamp": CLAMP, "tip": TIP, "channel": "red",
                     "stem": "dark", "width_px": 7.2, "release_frame": 57, "pull_side": "bottom",
                     "pull_px": 41.2, "cycles_per_frame": 0.083},
        "remark": "",
        "frames": [{"number": number, "caption": captions.get(number, "swinging"),
                    "image": drawn(axis_of(bend)), "axis": axis_of(bend)}
                   for number, bend in bends.items()],
        "limits": {"fps": limits(0, 1e8), "mm_per_px": limits(0, 1e3), "length_mm": limits(0, 1e5),
                   "diameter_mm": limits(0, 1e4), "density_kg_m3": limits(0, 1e5),
                   "clamp": limits(-1e5, 1e5, False), "release_frame": limits(0, 399, False),
                   "exposure_ms": limits(0, 1e3)},
        "checks": {"length_note": 0.04, "length_refusal": 0.15, "pixels_of_length": 6,
                   "width_smallest": 0.6, "width_largest": 1.6, "width_pixels": 1,
                   "cycles_per_frame_largest": 0.125, "modulus_smallest": 1e7,
                   "modulus_largest": 1e11, "mass_per_length_over_density_area": 2 / 3}}


def filled(setup: dict) -> str:
    """The page as the program writes it."""
    from setup import page_text
    return page_text(setup)


class UserTest(PageTest):
    """A browser and what a user does in it."""

    @classmethod
    def setUpClass(cls):
        place = tempfile.TemporaryDirectory()
        cls.addClassCleanup(place.cleanup)
        cls.folder = Path(place.name)
        cls.browser = started_browser()
        cls.addClassCleanup(cls.browser.quit)
        cls.browser.execute_cdp_cmd("Browser.setDownloadBehavior", {
            "behavior": "allow", "downloadPath": str(cls.folder)})

    def show(self, page: Path):
        self.browser.get(page.as_uri())
        self.wait("document.documentElement.dataset.ready === 'true'")

    def enter(self, **entries):
        for name, value in entries.items():
            entry = self.find(f"#{name}")
            entry.clear()
            entry.send_keys(value)

    def enter_specimen(self):
        # A chain of 390 px at 0.4 mm/px.
        self.enter(stem_id="V1", length_mm="156", diameter_mm="2.83", density_kg_m3="125", fps="960")

    def toml(self) -> dict:
        return tomllib.loads(self.ask("document.getElementById('toml').textContent"))

    def drag(self, selector: str, right: int, down: int):
        """Drags the centre of a handle by screen pixels."""
        from selenium.webdriver.common.action_chains import ActionChains
        self.ask("arguments[0].scrollIntoView({block: 'center'})", self.find("#picture"))
        x, y = self.ask("(() => { const m = document.querySelector(arguments[0]).getScreenCTM();"
                        "return [m.e, m.f]; })()", selector)
        actions = ActionChains(self.browser)
        actions.w3c_actions.pointer_action.move_to_location(round(x), round(y))
        actions.w3c_actions.pointer_action.pointer_down()
        actions.w3c_actions.pointer_action.move_to_location(round(x) + right // 2, round(y) + down)
        actions.w3c_actions.pointer_action.move_to_location(round(x) + right, round(y) + down)
        actions.w3c_actions.pointer_action.pointer_up()
        actions.perform()

    def pixel(self) -> float:
        """Screen pixels per frame pixel."""
        return self.ask("document.querySelector('#picture g').transform.baseVal.getItem(0).matrix.a")

    def screenshot(self, name: str):
        folder = os.environ.get("CULM_SCREENSHOTS")
        if not folder:
            return
        shot = self.browser.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": True})
        (Path(folder) / f"setup-{name}.png").write_bytes(base64.b64decode(shot["data"]))

class SetupPage(UserTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.sample = sample()

    def setUp(self):
        self.browser.set_window_size(*WIDE)
        self.open()

    def open(self, **changes):
        page = self.folder / "setup.html"
        page.write_text(filled({**copy.deepcopy(self.sample), **changes}), encoding="utf-8")
        self.show(page)

    def test_starts_with_what_was_detected(self):
        video = self.toml()["video"]
        self.assertEqual(video["frames"], 'a "b"/swing.mp4')
        self.assertEqual((video["up"], video["clamp_column"]), ("increasing_column", 42.0))
        self.assertNotIn("axis_row", video)
        self.assertEqual(self.find("#stem_id").get_attribute("value"), "video")
        self.assertIn("frame 57 was detected", self.find("#release-facts").text)
        self.assertIn("it was let go after frame 57 (release_frame)",
                      self.find("#assumed-list").text)
        self.assertIn("Frame 399: at rest", self.find("#frame-facts").text)
        self.assertFalse(self.find("#save").is_enabled())
        self.assertEqual(len(self.browser.find_elements("css selector", ".swept")), 7)
        self.assertEqual(self.ask("performance.getEntriesByType('resource')"
                                  ".filter((one) => !one.name.startsWith('data:')).length"), 0)

    def test_clamp_is_dragged_along_and_across_the_stem(self):
        self.drag("#clamp", 60, 1)
        video = self.toml()["video"]
        self.assertAlmostEqual(video["clamp_column"], 42 + 60 / self.pixel(), delta=0.11)
        self.assertNotIn("axis_row", video)  # within half a width of the detected axis
        self.drag("#clamp", 0, -30)
        self.assertAlmostEqual(self.toml()["video"]["axis_row"], 171.4 - 30 / self.pixel(), delta=0.11)

    def test_arrow_keys_move_the_tip(self):
        from selenium.webdriver.common.action_chains import ActionChains
        from selenium.webdriver.common.keys import Keys
        self.ask("document.getElementById('tip').focus()")
        label = lambda: self.find("#tip").get_attribute("aria-label")
        self.assertEqual(label(), "Tip: column 432.0, row 163.2")
        keys = lambda modifier, key: ActionChains(self.browser).key_down(modifier).send_keys(
            key).key_up(modifier).perform()
        ActionChains(self.browser).send_keys(Keys.RIGHT).perform()
        keys(Keys.SHIFT, Keys.UP)
        keys(Keys.ALT, Keys.DOWN)
        self.assertEqual(label(), "Tip: column 433.0, row 153.3")

    def test_scale_from_the_stem_from_a_line_and_from_a_number(self):
        self.enter_specimen()
        self.assertAlmostEqual(self.toml()["video"]["mm_per_px"], 0.4)
        self.find("#scale-line").click()
        self.enter(line_mm="115.2")  # of 288 pixels
        self.assertAlmostEqual(self.toml()["video"]["mm_per_px"], 0.4)
        self.drag("#scale-b", -100, 0)
        expected = 115.2 / (288 - 100 / self.pixel())
        self.assertAlmostEqual(self.toml()["video"]["mm_per_px"], expected, delta=0.0005)
        self.find("#scale-number").click()
        self.enter(mm_per_px="0.41")
        self.assertEqual(self.toml()["video"]["mm_per_px"], 0.41)
        self.assertFalse(self.find("#scale-a").is_displayed())

    def test_a_wrong_length_is_refused(self):
        self.enter_specimen()
        self.find("#scale-number").click()
        self.enter(mm_per_px="0.4")
        self.assertTrue(self.find("#save").is_enabled())
        self.assertIn("The stem swings at 79.7 Hz; a plain beam would need E = 2.0 GPa.",
                      self.find("#checks").text)
        self.enter(length_mm="200")
        self.assertIn("Error: The visible stem is 156 mm long", self.find("#checks").text)
        self.assertFalse(self.find("#save").is_enabled())
        self.assertIn("One error", self.find("#save-facts").text)
        self.assertEqual(self.find("#length_mm").get_attribute("aria-invalid"), "true")
        self.screenshot("refusal")
        self.enter(length_mm="166")
        self.assertIn("Note: The visible stem", self.find("#checks").text)
        self.assertTrue(self.find("#save").is_enabled())

    def test_numbers_outside_their_limits_are_refused(self):
        self.enter_specimen()
        self.enter(length_mm="0")
        self.assertIn("length_mm = 0 is not allowed: it must be larger than 0 and at most 1e5",
                      self.find("#checks").text)
        for wrong, reason in (("0,4", "write a decimal point"), ("ten", "is not a number")):
            self.enter(length_mm=wrong)
            self.assertIn(reason, self.find("#length_mm-fault").text)
        self.enter(length_mm="156", stem_id="V 1")
        self.assertIn("id = V 1 is not allowed", self.find("#checks").text)
        self.assertFalse(self.find("#save").is_enabled())

    def test_direction_must_agree_with_the_handles(self):
        self.enter_specimen()
        self.find("#up option[value=decreasing_row]").click()
        self.assertIn('The direction "upward" does not agree', self.find("#up-fault").text)
        self.assertFalse(self.find("#save").is_enabled())

    def test_saves_a_complete_file(self):
        self.enter_specimen()
        self.enter(exposure_ms="0.35")
        for choice in ("#stem-dark", "#channel-green"):
            self.find(choice).click()
        self.wait("document.querySelector('#picture image').getAttribute('href').includes('image/png')")
        for _ in range(4):
            self.find("#frame-previous").click()
        self.find("#release-use-shown").click()
        self.find("#save").click()
        file = self.folder / "video.toml"
        deadline = time.monotonic() + PATIENCE
        while not file.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        self.assertEqual(tomllib.loads(file.read_text()), {
            "video": {"frames": 'a "b"/swing.mp4', "fps": 960.0, "mm_per_px": 0.4,
                      "up": "increasing_column", "clamp_column": 42.0, "stem": "dark",
                      "best_channel": "green", "release_frame": 60},
            "stem": {"id": "V1", "length_mm": 156.0, "diameter_mm": 2.83, "density_kg_m3": 125.0},
            "camera": {"exposure_ms": 0.35}})
        self.assertTrue(file.read_text().startswith("# written with `culm setup`, culm 0.9\n"))
        self.screenshot("wide")
        self.find("#release-auto").click()
        self.assertNotIn("release_frame", self.toml()["video"])

    def test_zooms_to_the_clamp(self):
        before = self.pixel()
        self.ask("document.getElementById('clamp').focus()")
        for _ in range(5):
            self.find("#zoom-in").click()
        self.assertAlmostEqual(self.pixel() / before, 1.6 ** 5, delta=0.01)
        inside = self.ask("""(() => { const box = document.getElementById('picture').getBoundingClientRect();
            const m = document.getElementById('clamp').getScreenCTM();
            return [(m.e - box.left) / box.width, (m.f - box.top) / box.height]; })()""")
        self.assertAlmostEqual(inside[0], 0.5, delta=0.02)
        self.assertAlmostEqual(inside[1], 0.5, delta=0.02)
        self.screenshot("zoomed")
        self.drag("#clamp", 3, 0)
        self.assertLess(abs(self.toml()["video"]["clamp_column"] - 42), 1.0)
        self.find("#zoom-reset").click()
        self.assertAlmostEqual(self.pixel(), before, delta=0.01)

    def test_without_detection_the_handles_must_be_placed(self):
        from selenium.webdriver.common.keys import Keys
        self.open(detected=None, remark="No stem was detected <in> 400 frames.", bands=1, stated_fps=None,
                  frames=[{**frame, "axis": []} for frame in self.sample["frames"]])
        self.assertIn("<in>", self.find("#remark").text)
        self.enter_specimen()
        self.assertIn("The clamp was not detected", self.find("#checks").text)
        for handle in ("#clamp", "#tip"):
            self.ask("document.querySelector(arguments[0]).focus()", handle)
            self.browser.switch_to.active_element.send_keys(Keys.RIGHT)
        self.assertTrue(self.find("#save").is_enabled())
        video = self.toml()["video"]
        self.assertEqual((video["up"], video["clamp_row"], video["axis_column"]),
                         ("decreasing_row", 319.0, 240.5))
        self.screenshot("undetected")

    def test_a_rate_of_the_camera_needs_no_entry(self):
        self.open(rate_is_the_cameras=True, stated_fps=960.0)
        self.enter(length_mm="156", diameter_mm="2.83", density_kg_m3="125")
        self.assertTrue(self.find("#save").is_enabled())
        self.assertNotIn("fps", self.toml()["video"])

    def test_tab_reaches_handles_and_entries(self):
        from selenium.webdriver.common.keys import Keys
        self.find("#scale-line").click()
        self.ask("document.activeElement.blur()")
        self.find("body").send_keys(Keys.TAB)
        reached = []
        for _ in range(40):
            reached.append(self.ask("document.activeElement.id"))
            self.browser.switch_to.active_element.send_keys(Keys.TAB)
        self.assertTrue({"clamp", "tip", "scale-a", "scale-b", "frame", "up", "length_mm", "toml"}
                        <= set(reached), reached)

    def test_every_control_has_a_label(self):
        self.assertEqual(self.ask("""Array.from(document.querySelectorAll('input, select, button'))
            .filter((one) => !(one.labels && one.labels.length) && !one.textContent.trim()
                && !one.getAttribute('aria-label')).map((one) => one.id)"""), [])
        self.assertEqual(self.ask("""Array.from(document.querySelectorAll('body *'))
            .filter((one) => one.getClientRects().length && parseFloat(getComputedStyle(one).fontSize) < 13)
            .map((one) => one.tagName + one.id)"""), [])

    def test_fits_a_narrow_window(self):
        # A browser window has a smallest width; its emulation does not.
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": NARROW[0], "height": NARROW[1], "deviceScaleFactor": 1, "mobile": False})
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.clearDeviceMetricsOverride", {})
        self.find("#scale-line").click()
        self.wait("window.innerWidth === 420")
        self.assertLessEqual(self.ask("document.documentElement.scrollWidth"),
                             self.ask("document.documentElement.clientWidth"))
        self.screenshot("narrow")


class FromVideoToMeasurement(UserTest):
    """As a user with a camera and a ruler: a dark stem in front of an unevenly lit wall, sideways."""

    def test_gives_the_motion_of_the_beam(self):
        import drawn_video as truth
        truth.write_frames(self.folder / "frames")
        done = subprocess.run([PROGRAM, "setup", "frames", "-o", "S07"], cwd=self.folder, text=True,
                              capture_output=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.browser.set_window_size(*WIDE)
        self.show(self.folder / "S07/setup.html")
        self.enter(length_mm="160", diameter_mm="2.8", density_kg_m3="125", fps="960")
        self.assertIn("The stem swings at 80 Hz", self.find("#checks").text)
        # A ruler in the picture: a line of 100 px is 40 mm long.
        self.find("#scale-line").click()
        self.enter(line_mm="40")
        (left, top), (right, bottom) = [
            self.ask("(() => { const m = document.querySelector(arguments[0]).getScreenCTM();"
                     "return [m.e, m.f]; })()", name) for name in ("#scale-a", "#scale-b")]
        self.drag("#scale-b", round(left + 100 * self.pixel() - right), round(top - bottom))
        self.assertAlmostEqual(self.toml()["video"]["mm_per_px"], truth.MM_PER_PX, delta=0.01)
        self.screenshot("whole")
        self.find("#save").click()
        saved = self.folder / "video.toml"
        self.wait_for(saved)
        saved.rename(self.folder / "S07/video.toml")
        tracked = subprocess.run([PROGRAM, "track", "S07/video.toml", "-o", "measured", "-q"],
                                 cwd=self.folder, text=True, capture_output=True, check=False)
        self.assertEqual(tracked.returncode, 0, tracked.stderr)
        fitted = subprocess.run([PROGRAM, "fit", "measured", "--phase", "free", "--json", "-"],
                                cwd=self.folder, text=True, capture_output=True, check=False)
        b2 = json.loads(fitted.stdout)["stems"][0]["b2_hz"]["value"]
        self.assertAlmostEqual(b2 / truth.FREQUENCY, 1.0, delta=2e-3)

    def wait_for(self, file: Path):
        deadline = time.monotonic() + PATIENCE
        while not file.exists():
            self.assertLess(time.monotonic(), deadline, f"{file} is not saved")
            time.sleep(0.05)


if __name__ == "__main__":
    reason = obstacle()
    if reason:
        print(f"skipped: {reason}")
        sys.exit(SKIPPED)
    os.environ.setdefault("SE_AVOID_STATS", "true")
    unittest.main()
