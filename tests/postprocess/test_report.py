# SPDX-License-Identifier: BSD-3-Clause
"""The page of `culm report` shows the numbers of the files, is harmless, and is a single file."""
import contextlib
import io
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
import report
import synthetic_results
from backbones import SENTENCES
from culm.archive import Study
from report_folder import NASTY, Page, unpacked, write_everything
from synthetic_study import INITIAL_DEFLECTION, Synthetic, write_summary

LIBRARY = "!function(){var d3={version:'3.5.17'};this.d3=d3}(); '</script>';"
ROOT = Path(__file__).resolve().parents[2]


class ReportTest(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name) / "results"
        self.folder.mkdir()
        self.library = Path(place.name) / "d3.min.js"
        self.library.write_text(LIBRARY, "utf-8")

    def run_report(self, *arguments):
        """Exit code, standard output, standard error."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = report.main([str(a) for a in (self.folder, *arguments)])
            except SystemExit as stop:
                code = stop.code
        return code, out.getvalue(), err.getvalue()

    def page(self) -> Page:
        code, out, err = self.run_report("--d3-js", self.library)
        self.assertEqual((code, err), (0, ""))
        return Page(Path(out.strip()).read_text("utf-8"))

    def assert_refused(self, pattern, *arguments):
        code, out, err = self.run_report(*(arguments or ("--d3-js", self.library)))
        self.assertEqual((code, out), (2, ""))
        self.assertRegex(err, pattern)
        self.assertEqual(err.count("\n"), 1)


class Everything(ReportTest):
    def setUp(self):
        super().setUp()
        write_everything(self.folder)

    def test_is_on_one_page_with_the_verdicts_first(self):
        page = self.page()
        for kind in ("study", "calibration", "comparison", "diagnosis"):
            self.assertIn(kind, page.ids)
            self.assertLess(page.ids.index(kind), page.ids.index(f"{kind}-title"))
        words = page.said()
        self.assertIn("With quadratic_drag the published chain explains T2.", words)
        self.assertIn("UNKNOWN: the verdict.", words)
        self.assertIn("10 of 12 points were computed; 1 failed", words)
        for section in page.text.split("<section")[1:]:
            self.assertLess(section.index('class="verdict'), section.index("<h3>"))

    def test_stays_text_if_it_looks_like_markup(self):
        page = self.page()
        self.assertNotIn(NASTY, page.text)
        self.assertIn(NASTY, page.said())
        self.assertFalse([tag for tag, attributes in page.tags if "onmouseover" in attributes])
        scripts = [a for tag, a in page.tags if tag == "script" and "class" not in a]
        self.assertEqual(len(scripts), 2)  # the library and the page's own
        for drawing in page.drawings().values():
            self.assertNotIn("<script", json.dumps(drawing))

    def test_needs_no_network(self):
        page = self.page()
        for tag, attributes in page.tags:
            for name in ("src", "href"):
                if name in attributes:
                    self.assertRegex(attributes[name], "^(#|data:)", tag)
        policy = next(a["content"] for _, a in page.tags if "http-equiv" in a)
        self.assertIn("default-src 'none'", policy)
        self.assertNotIn("http", policy)

    def test_is_the_same_twice(self):
        written = []
        for name in ("one.html", "two.html"):
            self.run_report("--d3-js", self.library, "-o", self.folder / name)
            written.append((self.folder / name).read_bytes())
        self.assertEqual(written[0], written[1])

    def test_has_unique_ids_names_for_controls_and_words_for_drawings(self):
        page = self.page()
        self.assertEqual(len(page.ids), len(set(page.ids)))
        labels = {a["for"] for tag, a in page.tags if tag == "label"}
        for tag, attributes in page.tags:
            if tag in ("select", "input"):
                self.assertIn(attributes["id"], labels)
            if attributes.get("class") == "drawing":
                self.assertGreater(len(attributes["aria-label"]), 15)
            if tag == "a" and attributes["href"].startswith("#"):
                self.assertIn(attributes["href"][1:], page.ids)

    def test_says_of_a_damaged_file_why_it_is_left_out(self):
        file = self.folder / "comparison" / "comparison.json"
        document = synthetic_results.comparison()
        del document["ladder"][0]["where"]
        file.write_text(json.dumps(document), "utf-8")
        self.assertRegex(self.page().said(), "Not on this page: .*comparison.json: .*'where'")
        file.write_text("{", "utf-8")
        self.assertRegex(self.page().said(), "Not on this page: .*comparison.json: not JSON")


class OfAStudy(ReportTest):
    def page_of(self, **options) -> Page:
        self.truth = Synthetic(**options)
        self.truth.write(self.folder)
        return self.page()

    def test_holds_its_points_and_laws(self):
        drawings = self.page_of().drawings()
        done = self.truth.is_completed
        points, ours, published, residuals = drawings["study-regression-bond_damping"]["data"]
        np.testing.assert_allclose(points["x"], self.truth.decay_per_cycle[done], rtol=1e-6)
        np.testing.assert_allclose(points["y"], self.truth.damping[done], rtol=1e-6)
        entry = self.truth.summary()["regression"]["bond_damping"]
        for law, slope, intercept in ((ours, entry["slope"], entry["intercept"]),
                                      (published, -261.4, 2.5)):
            # Seven digits are written.
            np.testing.assert_allclose(law["y"], intercept + slope * np.array(law["x"]), rtol=1e-5)
        self.assertEqual(len(residuals["y"]), done.sum())
        counts = drawings["study-residuals-bond_damping"]["data"][0]["y"]
        percent = self.truth.residuals_percent("bond_damping")
        self.assertEqual(counts, np.histogram(percent, bins="auto")[0].tolist())

    def test_lets_a_point_be_picked_and_shows_its_history(self):
        picker, = self.page_of().of_class("picker-data")
        time = unpacked(picker["time"])
        point = "5"
        kept = picker["histories"][point]
        tip = 1e3 * np.interp(1e-3 * time, self.truth.time, self.truth.tip(5))
        # Times and deflections are rounded to 16 bits of their largest value each.
        np.testing.assert_allclose(unpacked(kept), tip, atol=2e-3 * 1e3 * INITIAL_DEFLECTION)
        self.assertAlmostEqual(kept["b2"], self.truth.frequency[5], delta=1e-4)
        self.assertNotIn("4", picker["histories"])  # failed
        self.assertEqual(picker["ids"][1], [4])
        self.assertEqual(picker["ids"][2], [9])  # missing
        self.assertIn("bond_damping = 100", picker["facts"][point])

    def test_says_that_it_has_no_histories(self):
        page = self.page_of(store="fit")
        self.assertFalse(page.of_class("picker-data"))
        self.assertIn("stores no histories", page.said())

    def test_lists_failed_points_with_their_reason(self):
        words = self.page_of().said()
        self.assertIn("Failed points", words)
        self.assertIn("NaN at 1 µs, β", words)
        self.assertNotIn("Failed points", self.page_of(failed_point=None, missing_point=None).said())

    def test_gives_the_reason_why_laws_are_undetermined(self):
        self.truth = Synthetic()
        self.truth.write(self.folder)
        write_summary(self.folder, {**self.truth.summary(), "regression": {
            "sqrt_youngs_modulus": {"reason": "too few points."},
            "bond_damping": {"reason": "too few points."}}})
        self.assertIn("No law for β: too few points.", self.page().said())

    def test_has_histograms_of_a_population(self):
        lengths = np.linspace(140.0, 170.0, 12)
        page = self.page_of(dampings=tuple(np.linspace(25, 200, 4)), moduli_gpa=(1.0, 2.0, 3.0),
                            extra_factors={"length_mm": ("mm", lengths)})
        self.assertNotIn("The population", page.said())  # a design of few levels
        many = tuple(np.linspace(25.0, 200.0, 20))
        page = self.page_of(dampings=many, moduli_gpa=(1.0, 2.0), failed_point=None,
                            missing_point=None)
        self.assertEqual(sum(page.drawings()["study-population-0"]["data"][0]["y"]), 40)

    def test_shows_the_contributions_of_the_factors_to_the_scatter(self):
        entry = {"shares": [{"group": "length_mm", "share": 0.25, "interval": [0.2, 0.3]}],
                 "rest": {"value": 0.75, "interval": [0.7, 0.8]}}
        self.truth = Synthetic()
        self.truth.write(self.folder)
        still = {"shares": [{"group": "length_mm", "share": None, "interval": [None, None]}],
                 "rest": {"value": None, "interval": [None, None]}}
        write_summary(self.folder, {**self.truth.summary(), "variance_shares": {
            "frequency": entry, "decay_per_cycle": still, "method": "regression"}})
        bar = self.page().drawings()["study-variance-shares-frequency"]["data"][0]
        self.assertEqual((bar["x"], bar["y"]), ([25, 75], ["length", "rest"]))
        np.testing.assert_allclose(bar["error_x"]["arrayminus"], [5, 5])

    def test_is_thinned_for_ten_thousand_points_and_says_so(self):
        page = self.page_of(dampings=tuple(np.linspace(25, 200, 100)),
                            moduli_gpa=tuple(np.linspace(1, 10, 100)), store="tip")
        self.assertLess(len(page.text), 2.5e6)
        cloud = page.drawings()["study-regression-bond_damping"]["data"][0]
        self.assertLessEqual(len(cloud["x"]), 1000)
        self.assertRegex(page.said(), r"About \d+ of 9998 points are drawn")
        self.assertIn("160 of 9998 points are on this page", page.said())
        picker, = page.of_class("picker-data")
        cells = np.array(picker["ids"][0])
        self.assertEqual(cells.shape, (100, 100))
        # Cells and ids are in order of rising damping (vertical) and modulus; two have no answer.
        expected = np.arange(10000)
        expected[[4, 9]] = -1
        np.testing.assert_array_equal(cells.ravel(), expected)

    def test_contains_the_numbers_of_the_archive_and_computes_none_anew(self):
        self.truth = Synthetic()
        with Study(self.truth.write(self.folder)) as study:
            entries = study.provenance
        words = self.page().said()
        self.assertIn(entries["compiler"], words)
        self.assertIn("[factors]", words)


class OfMeasurements(ReportTest):
    def test_comparison_shows_maps_ladder_and_motion(self):
        synthetic_results.write_comparison(self.folder)
        page = self.page()
        drawings = page.drawings()
        for place, predicted in enumerate(synthetic_results.PREDICTED.values()):
            z = np.array(drawings[f"comparison-map-{place}"]["data"][0]["z"], dtype=float)
            np.testing.assert_allclose(z, (synthetic_results.MEASURED - predicted).T, atol=1e-6)
        self.assertEqual(drawings["comparison-ladder"]["data"][0]["x"], [5, 1])
        self.assertIn("a taper <of> no use", page.said())
        animation, = page.of_class("animation-data")
        measured = unpacked(animation["measured"]).reshape(-1, 3)
        # Rounded to 16 bits of the largest value, 20 mm.
        np.testing.assert_allclose(measured, synthetic_results.MEASURED, atol=20.0 / 32000)
        self.assertEqual([model["name"] for model in animation["models"]],
                         list(synthetic_results.PREDICTED))

    def test_comparison_says_that_its_arrays_are_missing(self):
        synthetic_results.write_comparison(self.folder, with_motion=False)
        page = self.page()
        self.assertIn("deflections.csv", page.said())
        self.assertFalse(page.of_class("animation-data"))

    def test_amplitude_shows_measured_and_modelled(self):
        synthetic_results.write_comparison(self.folder)
        traces = self.page().drawings()["comparison-amplitude-damping-ratio"]["data"]
        self.assertEqual([trace["name"] for trace in traces],
                         ["measured", "baseline", "baseline + quadratic_drag"])
        self.assertEqual(traces[0]["y"], [0.03, 0.02])
        self.assertAlmostEqual(traces[1]["y"][0], 0.15 / 6.3, places=7)
        self.assertEqual(traces[0]["error_y"]["array"], [0.00196, 0.00196])

    def test_fit_shows_backbones_with_the_sentence_of_the_program(self):
        synthetic_results.write(self.folder, "fit.json",
                                synthetic_results.fit(synthetic_results.backbone_with_laws()))
        page = self.page()
        windows, law = page.drawings()["fit-backbone-0-1-damping-ratio"]["data"]
        self.assertEqual(windows["x"], [10.0, 5.0, 2.5])
        np.testing.assert_allclose(windows["y"], [0.031, 0.022, 0.019], rtol=1e-6)
        np.testing.assert_allclose([law["y"][0], law["y"][-1]], [0.019, 0.031], rtol=1e-6)
        self.assertEqual(len(page.drawings()["fit-backbone-0-2-frequency-hz"]["data"]), 1)
        self.assertIn("T2, mode 1: " + SENTENCES["edges or slip"], page.said())
        self.assertIn("T2, mode 2: no laws, because fewer than five windows", page.said())
        source = (ROOT / "src/reduce/backbone/amplitude_laws.cpp").read_text("utf-8")
        joined = re.sub(r'"\s*\n\s*"', "", source)
        for sentence in SENTENCES.values():
            self.assertIn(f'"{sentence}"', joined)

    def test_calibration_shows_stems_failures_and_population(self):
        synthetic_results.write_calibration(self.folder)
        page = self.page()
        words = page.said()
        self.assertIn("S1: Y = 2.0 GPa; the model is adequate.", words)
        self.assertIn("1 of 3 stems could not be calibrated", words)
        self.assertIn("no motion", words)
        self.assertIn("157 mm, 2.83 mm, 82.3 mg", words)
        self.assertEqual(len(page.of_class("animation-data")), 2)
        residual = page.drawings()["calibration-map-002"]["data"][0]["z"]
        self.assertIsNone(residual[synthetic_results.UNSEEN[1]][synthetic_results.UNSEEN[0]])
        # Length and noise each cause half of the variance, so their bars have the same height.
        for bars in page.drawings()["calibration-budget-001"]["data"]:
            self.assertEqual(bars["x"], ["length", "readings"])
            self.assertAlmostEqual(bars["y"][0], bars["y"][1], places=9)
        self.assertIn("No uncertainty is stated for length", words)

    def test_verdict_of_a_diagnosis_is_its_own_sentences(self):
        for verdict in ("adequate", "effect", "tie", "unknown"):
            with self.subTest(verdict):
                synthetic_results.write(self.folder, "diagnosis.json",
                                        synthetic_results.diagnosis(verdict=verdict))
                page = self.page()
                for sentence in (f"{verdict.upper()}: the verdict.", "Why: with it the residuals"):
                    self.assertIn(sentence, page.said())
                self.assertEqual("diagnosis-force-against-velocity" in page.drawings(),
                                 verdict == "unknown")

    def test_diagnosis_draws_the_probability_of_every_explanation(self):
        synthetic_results.write(self.folder, "diagnosis.json", synthetic_results.diagnosis())
        drawing = self.page().drawings()["diagnosis-explanations"]
        self.assertEqual(drawing["data"][0]["x"], [0.97, 0.03])
        self.assertEqual(drawing["layout"]["levels"][0]["at"], 0.95)

    def test_missing_numbers_are_dashes(self):
        document = synthetic_results.comparison()
        for rung in document["ladder"][:2]:
            for entry in rung["parameters"].values():
                entry["stderr"] = None
            rung["verdict"]["p_value"] = None
            rung["where"]["by_height"][0]["rms_over_noise"] = None
            rung["where"]["banding"]["heights"][0]["measured"]["stderr"] = None
        synthetic_results.write(self.folder, "comparison.json", document)
        self.assertIn("–", self.page().said())


class Refusals(ReportTest):
    def test_are_one_sentence(self):
        self.assert_refused("holds no results: .*study.h5")
        self.assert_refused("cannot be read", "--d3-js", self.folder / "nothing.js")
        self.library.write_text("alert(1)", "utf-8")
        self.assert_refused("is not D3 version 3")
        self.folder = self.folder / "nowhere"
        self.library.write_text(LIBRARY, "utf-8")
        self.assert_refused("is not a folder")

    def test_are_those_of_the_reader_for_the_only_result(self):
        (self.folder / "study.h5").write_bytes(b"no HDF5")
        self.assert_refused("study.h5 is not a readable HDF5 file")

    def test_name_a_module_that_is_missing(self):
        synthetic_results.write_comparison(self.folder)
        # Without site packages Python finds neither numpy nor h5py.
        finished = subprocess.run([sys.executable, "-S", "-E", "-B", ROOT / "postprocess/report.py",
                                   self.folder], capture_output=True, text=True, check=False,
                                  env={**os.environ, "CULM_TRIED_PYTHON": "/usr/bin/python3",
                                       "CULM_PYTHON": ""})
        self.assertEqual(finished.returncode, 2)
        self.assertRegex(finished.stderr, r"lacks numpy and h5py: .*CULM_PYTHON")
        self.assertEqual(finished.stderr.count("\n"), 1)

    def test_leave_no_half_page(self):
        synthetic_results.write_comparison(self.folder)
        (self.folder / "a_file").write_text("", "utf-8")
        self.assert_refused("a_file", "--d3-js", self.library, "-o",
                            self.folder / "a_file" / "report.html")
        self.assertFalse(list(self.folder.glob("**/*.tmp")))


if __name__ == "__main__":
    unittest.main()
