# SPDX-License-Identifier: BSD-3-Clause
"""The parts of the report: thinning keeps outliers, no text can end a script, scales."""
import json
import tempfile
import unittest
from pathlib import Path

import numpy as np
import synthetic_results
import test_report_laboratory
from json_schema import schema_faults, schema_of
from report_folder import unpacked
from report_page import drawing, library, markup
from report_page.diagnosis import ladder_labels
from report_page.picker import kept_samples, packed


class Thinning(unittest.TestCase):
    def test_keeps_the_most_important_points_and_spreads_the_rest(self):
        importance = np.zeros(5000)
        importance[[17, 4321]] = 1.0
        rows = drawing.chosen_rows(importance, 100)
        self.assertEqual(rows.size, 100)
        self.assertEqual(drawing.chosen_rows(np.zeros(5000), 100).size, 100)
        self.assertTrue({0, 17, 4321, 4999} <= set(rows.tolist()))
        np.testing.assert_array_equal(drawing.chosen_rows(np.zeros(5), 100), np.arange(5))

    def test_keeps_the_largest_frame_of_each_group(self):
        values = np.zeros((2000, 2))
        values[1234, 1] = -7.0
        values[:, 0] = np.nan
        time, kept, group = drawing.thinned(np.arange(2000.0), values)
        self.assertEqual((group, kept.shape), (3, (667, 2)))
        self.assertEqual(kept[1234 // 3, 1], -7.0)
        self.assertTrue(np.isnan(kept[:, 0]).all())
        self.assertEqual(time[1], 3.0)

    def test_never_aliases_the_fastest_motion(self):
        time = np.linspace(0.0, 2.0, 40001)
        samples = kept_samples(time, 100.0)
        self.assertLessEqual(samples.size, 600)
        self.assertLessEqual(time[samples[1]], 1.0 / (20 * 100.0) + 1e-12)
        np.testing.assert_array_equal(kept_samples(time[:50], 100.0), np.arange(50))


class Packing(unittest.TestCase):
    def test_is_good_to_half_a_unit_and_keeps_gaps(self):
        values = np.array([[1.0, -3.0], [np.nan, 0.1]])
        found = unpacked(packed(values)).reshape(2, 2)
        np.testing.assert_allclose(found, values, atol=0.5 * 3.0 / 32000)
        np.testing.assert_array_equal(unpacked(packed(np.array([np.nan]))), [np.nan])


class Markup(unittest.TestCase):
    def test_json_cannot_end_its_script(self):
        text = markup.embedded_json({"a": "</script><!--", "b": np.array([1.0, np.nan, 1 / 3])})
        self.assertNotIn("<", text)
        self.assertEqual(json.loads(text), {"a": "</script><!--", "b": [1, None, 0.3333333]})

    def test_long_tables_say_how_much_is_not_shown(self):
        self.assertIn("50 more rows", markup.table(["n"], [[k] for k in range(250)]))

    def test_numbers_in_tables_are_readable(self):
        self.assertIn(">128396<", markup.table(["n"], [[128396.4]]))
        self.assertIn(">–<", markup.table(["n"], [[None]]))
        self.assertEqual(markup.with_error({"value": 1.2996, "stderr": 0.0043}), "1.2996 ± 0.0084")


class Axes(unittest.TestCase):
    def test_logarithmic_ticks_are_few_and_inside(self):
        for values in ([1.0, 1.3], [0.04, 0.2], [1e-8, 1e-3], [3.0]):
            with self.subTest(values):
                made = drawing.log_axis("x", values)
                ticks = np.log10(np.asarray(made["tickvals"], dtype=float))
                self.assertTrue(1 <= ticks.size <= 10)
                low, high = made["range"]
                self.assertLess(low, np.log10(min(values)))
                self.assertGreater(high, np.log10(max(values)))


class Library(unittest.TestCase):
    def test_is_safe_within_a_script_whatever_it_holds(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "d3.min.js"
            file.write_text("!function(){var d3={version:'3.5.17'}; '</script><!--'", "utf-8")
            source, version = library.d3_js(file)
        self.assertEqual(version, "3.5.17")
        self.assertNotIn("</script", source)
        self.assertNotIn("<!--", source)

    def test_is_refused_in_another_version(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "d3.min.js"
            file.write_text("// https://d3js.org v7.8.5 Copyright 2010-2023", "utf-8")
            with self.assertRaisesRegex(library.LibraryMissing, "is not D3 version 3"):
                library.d3_js(file)


class Ladder(unittest.TestCase):
    def test_labels_say_what_a_model_adds_to_the_one_before(self):
        """The effects of a model are in the library's order, not in that of the ladder."""
        ladder = [{"model": ["baseline"]}, {"model": ["baseline", "power_drag"]},
                  {"model": ["baseline", "clamp_compliance", "power_drag"]}]
        self.assertEqual(ladder_labels(ladder), ["baseline", "+ power_drag", "+ clamp_compliance"])


class SyntheticResults(unittest.TestCase):
    def test_are_as_the_schemas_want_them(self):
        documents = [("comparison", synthetic_results.comparison()),
                     ("calibration", synthetic_results.calibration()),
                     ("laboratory", test_report_laboratory.laboratory())]
        documents += [("diagnosis", synthetic_results.diagnosis(verdict=verdict))
                      for verdict in ("adequate", "effect", "tie", "unknown")]
        for name, document in documents:
            document = {**document, "provenance": synthetic_results.PROVENANCE}
            schema = schema_of(name)
            self.assertEqual(schema_faults(json.loads(json.dumps(document)), schema), [], name)


if __name__ == "__main__":
    unittest.main()
