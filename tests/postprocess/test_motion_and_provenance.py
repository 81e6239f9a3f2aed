# SPDX-License-Identifier: BSD-3-Clause
"""How the report and the figures show the motion, provenance and a tracked recording."""
import json
import tempfile
import unittest
from pathlib import Path

import numpy as np
import synthetic_results
from command_results import Diagnosis, TrackError, TrackResults
from report_folder import unpacked
from report_page.diagnosis import diagnosis_section
from report_page.measured import read_motion
from report_page.markup import provenance_rows
from fit_figures import displacements_figure


class Folder(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)


class DiagnosisMotion(Folder):
    def markup(self) -> str:
        synthetic_results.write(self.folder, "diagnosis.json", synthetic_results.diagnosis())
        return diagnosis_section(Diagnosis(self.folder), "diagnosis", "here").markup()

    def test_moves_the_stem_on_the_page(self):
        synthetic_results.write_deflections(self.folder)
        markup = self.markup()
        begin = markup.index(">", markup.index("animation-data")) + 1
        animation = json.loads(markup[begin:markup.index("</script>", begin)])
        self.assertEqual([model["name"] for model in animation["models"]],
                         list(synthetic_results.PREDICTED))
        measured = unpacked(animation["measured"]).reshape(-1, 3)
        # Rounded to 16 bits of the largest value, 20 mm.
        np.testing.assert_allclose(measured, synthetic_results.MEASURED, atol=20.0 / 32000)

    def test_is_left_out_where_it_is_not_known(self):
        self.assertNotIn("animation-data", self.markup())
        (self.folder / "deflections.csv").write_text("no table", "utf-8")
        self.assertNotIn("animation-data", self.markup())

    def test_keeps_models_in_the_order_of_the_columns(self):
        file = self.folder / "many.csv"
        names = [f"model {number}" for number in range(11)]
        file.write_text(",".join(["time_s", "measured h=100mm",
                                  *(f"{name} h=100mm" for name in names)]) + "\n0,1,"
                        + ",".join(map(str, range(11))) + "\n", "utf-8")
        motion = read_motion(file)
        self.assertEqual([name for name, _ in motion.models], names)
        self.assertEqual([predicted.tolist() for _, predicted in motion.models],
                         [[[float(k)]] for k in range(11)])
        self.assertIsNone(read_motion(self.folder / "none.csv"))


class Provenance(unittest.TestCase):
    def test_is_written_as_text(self):
        facts = dict(map(tuple, provenance_rows({"provenance": synthetic_results.PROVENANCE})[:4]))
        self.assertEqual(facts["command"], "culm diagnose T2 -o 'my folder'")
        self.assertEqual(facts["written by"], "culm 0.1.0 (abc), 2026-11-21 23:59:07 UTC")
        self.assertEqual(facts["time"], "12.5 s on 2 ranks, 24 s of processor time")
        inputs = [text for name, text in provenance_rows(
            {"provenance": synthetic_results.PROVENANCE}) if name == "input"]
        self.assertEqual(inputs, ["T2/stem.toml: 155 bytes, CRC-32 0123abcd",
                                  "T2/gone.csv: could not be read again"])

    def test_is_left_out_for_older_documents(self):
        self.assertEqual(provenance_rows({}), [])


class TrackedRecording(Folder):
    def write(self, table: str):
        (self.folder / "track.json").write_text(json.dumps(
            {"stem": "V1", "fps": 960.0, "release": {"pull_mm": 19.0, "pull_at_height_mm": 150.0}}),
            "utf-8")
        (self.folder / "deflection.csv").write_text(table, "utf-8")

    def test_is_drawn_at_every_height_with_its_release(self):
        self.write("# a remark\ntime_s,h=50mm,h=150mm\n-0.001,3,19\n0,3,19\n0.001,,-4\n")
        axes = displacements_figure(TrackResults(self.folder)).axes[0]
        low, high = axes.lines[:2]
        np.testing.assert_allclose(high.get_xdata(), [-1.0, 0.0, 1.0])
        np.testing.assert_allclose(high.get_ydata(), [19.0, 19.0, -4.0])
        np.testing.assert_allclose(low.get_ydata(), [3.0, 3.0, np.nan])
        self.assertEqual(axes.get_legend().get_texts()[0].get_text(), "release")

    def test_is_refused_if_it_cannot_be_read(self):
        with self.assertRaisesRegex(TrackError, "track.json: No such file"):
            TrackResults(self.folder)
        self.write("time_s,h=50mm\nx,1\n")
        with self.assertRaisesRegex(TrackError, "not readable as a tracked recording"):
            TrackResults(self.folder)


if __name__ == "__main__":
    unittest.main()
