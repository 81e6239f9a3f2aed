# SPDX-License-Identifier: BSD-3-Clause
"""The page of a laboratory: its sentences, a drawing and a row for each stem, and the power."""
import copy
import re
import unittest
import zlib

import numpy as np
import synthetic_results
from report_folder import NASTY
from test_report import ReportTest

SECRET = 271.828
RECORDING = "time_s,h=50mm,h=150mm\n-0.001,1,9\n0,1,8.5\n0.01,,-7\n0.02,0.5,\n0.03,-0.5,6\n"
STEM = '[stem]\nid = "film of {0}"\nspecimen = "{0}"\n'


def numbers(modulus, damping):
    return {"bond_youngs_modulus_pa": modulus, "bond_youngs_modulus_standard_error_pa": 3e7,
            "bond_damping": damping, "bond_damping_standard_error": 1.0, "rms_mm": 0.1}


def stem(name, modulus, damping, **members):
    return {"specimen": name, "rig": "R", "before": numbers(modulus, damping),
            "after": numbers(1.1 * modulus, 0.8 * damping), "over_noise_before": 1.5,
            "over_noise": 1.0, "finding": "adequate", "failed_tests": "", "own_effects": [],
            "own_parameters": [], "youngs_modulus_distance": 0.1, "damping_distance": None,
            **members}


def effect(name, probability, **members):
    return {"effect": name, "rig": "R", "known": False, "probability": probability,
            "family": "air", "family_probability": probability, "stems_needed": 0.0,
            "log_odds": None, "log_odds_per_stem": None, "parameters": [], **members}


def laboratory(outsider="S3"):
    """Two stems and one that was left out; the odds of one effect of the rig are known."""
    compliance = effect(
        "clamp_compliance", 0.8, stems_needed=2.0, log_odds=1.5, log_odds_per_stem=0.75,
        parameters=[{"name": "stiffness_nm_rad", "unit": "N m/rad", "value": 12.3,
                     "interval_95": [9.0, 19.4]}])
    population = {"bond_youngs_modulus_pa": synthetic_results.sample(2e9, 5e8),
                  "bond_damping": synthetic_results.sample(200.0, 50.0), "correlation": 0.36}
    folders = ["one", "two"]
    return {
        "format": "culm-laboratory", "version": 1, "conclusion": "effect",
        "reason": "these effects hold 95 % of the probability", "probability": 0.98,
        "sentences": ["EFFECT: air of rig R (most like quadratic_drag) is missing from the "
                      "published chain (probability 0.98)."],
        "families": [{"family": "air", "members": ["quadratic_drag"], "by_family": True,
                      "rig": "R"}],
        "alternatives": [{"families": [], "probability": 0.98}],
        "explanations": [{"effects": ["quadratic_drag of rig R"], "probability": 0.98},
                         {"effects": [], "probability": 0.02}],
        "immaterial": [],
        "rig_effects": [compliance, effect("quadratic_drag", 0.99999)],
        "stem_effects": [{"effect": "taper", "probability": 0.97, "family": "stem geometry",
                          "family_probability": 0.98, "specimens": ["S2"],
                          "possible_specimens": ["S1"]}],
        "population": {"before": population,
                       "after": {**population, "correlation": None,
                                 "bond_youngs_modulus_pa": synthetic_results.sample(2.2e9, 5e8)}},
        "stems": [stem("S1", 2e9, 150.0),
                  stem("S2", 2.5e9, 250.0, youngs_modulus_distance=-4.2, own_effects=["taper"],
                       own_parameters=[{"name": "taper.relative_change", "value": -0.1,
                                        "standard_error": 0.01}]),
                  {"specimen": outsider, "rig": "R", "failure": "no frame <after> the release"}],
        "detection_limits": [{"effect": "rolling_shutter", "rig": "R", "parameter": "readout_s",
                              "unit": "s", "one_stem": 5.3e-5, "all_stems": None}],
        "models": [{"effects": [], "log_evidence": 0.0, "probability": 0.02}],
        "largest_unvisited_log_evidence": None, "folders": folders,
        "options": {"law": "consistent", "spheres": None, "window_s": None, "max_effects": 3,
                    "candidates": ["taper"], "known": []},
        "provenance": {**synthetic_results.PROVENANCE, "inputs": [
            {"file": f"{folder}/{file}", "bytes": len(text), "crc32": f"{zlib.crc32(text):08x}"}
            for folder, name in zip(folders, ("S1", "S2"))
            for file, text in (("stem.toml", STEM.format(name).encode()),
                               ("deflection.csv", RECORDING.encode()))]}}


class OfALaboratory(ReportTest):
    def setUp(self):
        super().setUp()
        for folder, name in (("one", "S1"), ("two", "S2")):
            (self.folder / folder).mkdir()
            (self.folder / folder / "stem.toml").write_text(STEM.format(name), "utf-8")
            (self.folder / folder / "deflection.csv").write_text(RECORDING, "utf-8")

    def page_of(self, document):
        synthetic_results.write(self.folder, "laboratory.json", document)
        return self.page()

    @staticmethod
    def stem_rows(page):
        """The HTML of the rows of the table of all stems."""
        table = page.text.split("<h3>The stems</h3>")[1].split("</table>")[0]
        return re.findall("<tr>.*?</tr>", table.split("<tbody>")[1], re.DOTALL)

    def test_says_the_verdict_the_effects_and_the_population(self):
        words = self.page_of(laboratory()).said()
        for sentence in ("EFFECT: air of rig R (most like quadratic_drag) is missing from the "
                         "published chain (probability 0.98).",
                         "1 of 3 stems left out: S3.", "Not explained, or far from the others: S2.",
                         "12.3 N m/rad 9 to 19.4 N m/rad", "> 0.999", "taper 0.97 stem geometry: 0.98 1 of 2 S2 S1",
                         "Y: mean 2 GPa, scatter 0.5 before; 2.2, 0.5 after (+10 % in the mean).",
                         "Correlation of Y and β: 0.36 before, – after.",
                         "rolling_shutter R readout_s s – 5.3·10⁻⁵", "culm 0.1.0 (abc)"):
            self.assertIn(sentence, words)

    def test_has_a_row_for_every_stem_and_a_drawing_for_every_recording(self):
        page = self.page_of(laboratory())
        first, second, third = self.stem_rows(page)
        self.assertEqual(page.text.count('<svg class="sparkline"'), 2)
        self.assertIn('<a href="one/">S1</a>', first)
        self.assertIn("2.000 ± 0.059".replace(" ", "\N{NO-BREAK SPACE}"), first)
        self.assertNotIn("<strong>", first)
        self.assertIn("<strong>Y: −4.2 deviations from the median</strong>", second)
        self.assertIn("taper.relative_change", second)
        self.assertIn("<strong>left out</strong>: no frame &lt;after&gt; the release", third)
        self.assertNotIn("svg", third)
        label = next(a["aria-label"] for tag, a in page.tags if a.get("class") == "sparkline")
        self.assertEqual(label, "S1: deflection at 150 mm over 31 ms, at most 9 mm")

    def test_says_how_many_stems_would_decide(self):
        page = self.page_of(laboratory())
        words = page.said()
        self.assertIn("About 2 more stems like these would make clamp_compliance of rig R certain.",
                      words)
        self.assertIn("quadratic_drag of rig R is certain with the 2 stems.", words)
        self.assertIn("Not computed: quadratic_drag.", words)
        (curve,) = page.drawings()["laboratory-power"]["data"]
        self.assertEqual(curve["x"], [1, 2, 3, 4, 5, 6])
        log_odds = 1.5 + 0.75 * (np.array(curve["x"]) - 2)
        np.testing.assert_allclose(curve["y"], 1.0 / (1.0 + np.exp(-log_odds)), rtol=1e-6)
        self.assertGreaterEqual(curve["y"][3], 0.95)
        self.assertLess(curve["y"][2], 0.95)

    def test_says_that_more_stems_do_not_decide(self):
        document = laboratory()
        document["rig_effects"][0].update(stems_needed=0.0, log_odds_per_stem=-0.1)
        self.assertIn("More stems like these would not make clamp_compliance of rig R certain.",
                      self.page_of(document).said())

    def test_is_readable_if_an_older_version_did_not_compute_the_power(self):
        document = laboratory()
        for each in document["rig_effects"]:
            del each["log_odds"], each["log_odds_per_stem"]
        page = self.page_of(document)
        self.assertNotIn("laboratory-power", page.drawings())
        self.assertIn("The probability against the number of stems was not computed.", page.said())
        self.assertIn("About 2 more stems like these", page.said())

    def test_draws_the_distributions_and_the_correlation(self):
        drawings = self.page_of(laboratory()).drawings()
        _, before, mean, after, _ = drawings["laboratory-strip-youngs-modulus"]["data"]
        np.testing.assert_allclose(before["x"], [2.0, 2.5])
        np.testing.assert_allclose(after["x"], [2.2, 2.75])
        self.assertEqual((mean["x"], mean["error_x"]["array"]), ([2], [0.5]))
        far = drawings["laboratory-scatter"]["data"][-1]
        self.assertEqual((far["x"], far["y"], far["text"]), ([2.75], [200], ["S2"]))

    def test_links_from_the_page_wherever_it_is(self):
        synthetic_results.write(self.folder, "laboratory.json", laboratory())
        page = self.folder.parent / "pages" / "lab.html"
        self.run_report("--d3-js", self.library, "-o", page)
        self.assertIn('href="../results/one/"', page.read_text("utf-8"))

    def test_does_not_draw_a_recording_that_is_not_the_diagnosed_one(self):
        changed = RECORDING.replace("8.5", f"{SECRET}")
        (self.folder / "one" / "deflection.csv").write_text(changed, "utf-8")
        (self.folder / "two" / "deflection.csv").write_text(RECORDING.replace("8", "3"), "utf-8")
        page = self.page_of(laboratory())
        self.assertNotIn('<svg class="sparkline"', page.text)
        self.assertIn("2 of 2 recordings are not drawn", page.said())
        document = laboratory()
        del document["provenance"]
        self.assertNotIn('<svg class="sparkline"', self.page_of(document).text)

    def test_keeps_markup_of_a_name_as_text(self):
        document = copy.deepcopy(laboratory(NASTY))
        document["stems"][0]["specimen"] = document["stems"][1]["own_effects"][0] = NASTY
        document["rig_effects"][0]["effect"] = document["folders"][0] = NASTY
        page = self.page_of(document)
        self.assertNotIn(NASTY, page.text)
        self.assertIn(NASTY, page.said())
        self.assertFalse([tag for tag, attributes in page.tags if "onmouseover" in attributes])

    def test_says_of_another_format_why_it_is_left_out(self):
        document = laboratory()
        del document["population"]
        synthetic_results.write(self.folder, "laboratory.json", document)
        self.assert_refused("laboratory.json: not as this version .*'population'")


if __name__ == "__main__":
    unittest.main()
