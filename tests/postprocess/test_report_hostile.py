# SPDX-License-Identifier: BSD-3-Clause
"""Malicious results: a page never contains other files of the machine, and runs only its own
scripts."""
import base64
import hashlib
import io
import json
import unittest
from pathlib import Path

import compare_figures
import diagnose_figures
import h5py
import numpy as np
import synthetic_results
from command_results import Comparison, Diagnosis
from culm.archive import Study, StudyError
from report_folder import NASTY
from synthetic_study import Synthetic
from test_report import ReportTest

SECRET = 271828.0


class StudyThatNamesOtherFiles(ReportTest):
    """The column `frequency` of study.h5 is taken from a file outside of the folder."""

    def setUp(self):
        super().setUp()
        self.truth = Synthetic()
        self.truth.write(self.folder)
        self.other = self.folder.parent / "private.h5"
        values = np.full(self.truth.points, SECRET)
        with h5py.File(self.other, "w") as file:
            file["frequency"] = values
        (self.folder.parent / "private.bin").write_bytes(values.tobytes())

    def replace(self, name, make):
        """Replaces `name` by the result of `make(file, path)`, with the same attributes."""
        with h5py.File(self.folder / "study.h5", "r+") as file:
            attributes = dict(file[name].attrs)
            del file[name]
            made = make(file, name)
            if made is not None:
                for key, value in attributes.items():
                    made.attrs[key] = value

    def assert_not_read(self, sentence):
        with Study(self.folder) as study, self.assertRaisesRegex(StudyError, sentence):
            study["frequency"]
        page = self.page()
        self.assertRegex(page.said(), sentence)
        self.assertNotIn(f"{SECRET:.0f}", page.text)

    def test_is_refused_with_an_external_link(self):
        def link(file, name):
            file[name] = h5py.ExternalLink(str(self.other), "/frequency")
        self.replace("results/frequency", link)
        self.assert_not_read(
            r"study.h5: /results/frequency is an external link to /frequency in .*private.h5")

    def test_is_refused_with_a_soft_link_through_an_external_one(self):
        def link(file, name):
            file["elsewhere"] = h5py.ExternalLink(str(self.other), "/")
            file[name] = h5py.SoftLink("/elsewhere/frequency")
        self.replace("results/frequency", link)
        self.assert_not_read(
            "study.h5: /results/frequency is a soft link to /elsewhere/frequency")

    def test_is_refused_with_a_virtual_dataset(self):
        def virtual(file, name):
            layout = h5py.VirtualLayout((self.truth.points,), float)
            layout[:] = h5py.VirtualSource(str(self.other), "frequency", (self.truth.points,))
            return file.create_virtual_dataset(name, layout)
        self.replace("results/frequency", virtual)
        self.assert_not_read("study.h5: /results/frequency keeps its numbers in other files")

    def test_is_refused_with_external_storage(self):
        def external(file, name):
            return file.create_dataset(
                name, (self.truth.points,), float,
                external=[(str(self.folder.parent / "private.bin"), 0, 8 * self.truth.points)])
        self.replace("results/frequency", external)
        self.assert_not_read("study.h5: /results/frequency keeps its numbers in other files")

    def test_is_refused_with_a_group_that_is_a_link(self):
        def link(file, name):
            file[name] = h5py.ExternalLink(str(self.other), "/")
        self.replace("provenance", link)
        self.assert_refused("study.h5: /provenance is an external link")

    def test_is_not_refused_for_hard_links_as_culm_writes_them(self):
        with h5py.File(self.folder / "study.h5", "r+") as file:
            file["results/same"] = file["results/frequency"]
            file["results"].attrs["columns"] = [*file["results"].attrs["columns"], "same"]
        with Study(self.folder) as study:
            np.testing.assert_array_equal(study["same"], study["frequency"])


class Motion(ReportTest):
    def test_is_not_drawn_behind_a_symbolic_link(self):
        synthetic_results.write_comparison(self.folder)
        file = self.folder / "deflections.csv"
        file.rename(self.folder.parent / "private.csv")
        file.symlink_to(self.folder.parent / "private.csv")
        self.assertFalse(self.page().of_class("animation-data"))

    def test_is_not_drawn_of_a_damaged_table_and_the_page_says_why(self):
        synthetic_results.write_comparison(self.folder)
        (self.folder / "deflections.csv").write_text("time_s,measured h=1mm\n0,x\n", "utf-8")
        page = self.page()
        self.assertFalse(page.of_class("animation-data"))
        self.assertIn("deflections.csv: not readable as the motion", page.said())


class Picture(ReportTest):
    def test_is_omitted_behind_a_symbolic_link_and_if_it_is_large(self):
        (self.folder / "track.json").write_text(json.dumps(
            {"stem": "V1", "fps": 960.0, "frames_tracked": 3, "swing_hz": 60.0, "view": {},
             "contrast": {}, "release": {"pull_mm": 19.0, "pull_at_height_mm": 150.0},
             "heights": []}), "utf-8")
        (self.folder / "deflection.csv").write_text(
            "time_s,h=50mm,h=150mm\n-0.001,3,19\n0,3,19\n0.001,2,-4\n", "utf-8")
        sheet = self.folder / "contact_sheet.png"
        sheet.write_bytes(b"a picture")
        self.assertIn("image/png", self.page().text)
        sheet.write_bytes(bytes(4_000_000))
        self.assertNotIn("image/png", self.page().text)
        self.assertIn("contact_sheet.png has 4.0 MB", self.page().said())
        sheet.write_bytes(b"a picture")
        private = self.folder.parent / "private.png"
        sheet.rename(private)
        sheet.symlink_to(private)
        self.assertNotIn("image/png", self.page().text)


class Scripts(ReportTest):
    def test_are_only_those_whose_hashes_the_policy_names(self):
        synthetic_results.write_comparison(self.folder)
        page = self.page()
        policy = next(a["content"] for _, a in page.tags if "http-equiv" in a)
        rule = next(part for part in policy.split(";") if part.strip().startswith("script-src"))
        self.assertNotIn("unsafe-inline", rule)
        bodies = [part.split("</script>")[0] for part in page.text.split("<script>")[1:]]
        self.assertEqual(len(bodies), 2)
        for body in bodies:
            found = base64.b64encode(hashlib.sha256(body.encode()).digest()).decode()
            self.assertIn(f"'sha256-{found}'", rule)
        self.assertFalse([a for tag, a in page.tags if tag == "script" and a
                          and a.get("type") != "application/json"])


class TextWhereANumberBelongs(ReportTest):
    """Replaces every text and every number of a document by markup, one after the other. The page
    must show it as text, or report that the document does not follow its schema."""

    def page_text(self) -> str:
        code, out, _ = self.run_report("--d3-js", self.library)
        return Path(out.strip()).read_text("utf-8") if code == 0 else ""

    def test_stays_text_in_a_failure(self):
        document = synthetic_results.diagnosis()
        document["models"][1]["failure"] = NASTY
        synthetic_results.write(self.folder, "diagnosis.json", document)
        page = self.page()
        self.assertNotIn(NASTY, page.text)
        self.assertIn(NASTY, page.said())

    def assert_never_markup(self, name, document):
        places = list(leaves(document))
        self.assertGreater(len(places), 50)
        for holder, key in places:
            before = holder[key]
            holder[key] = NASTY
            synthetic_results.write(self.folder, f"{name}.json", document)
            with self.subTest(name, key=key):
                self.assertNotIn("<script>window.injected", self.page_text())
            holder[key] = before

    def test_stays_text_in_a_comparison(self):
        self.assert_never_markup("comparison", synthetic_results.comparison())

    def test_stays_text_in_a_diagnosis(self):
        for verdict in ("effect", "unknown"):
            self.assert_never_markup("diagnosis", synthetic_results.diagnosis(verdict=verdict))


class Figures(ReportTest):
    def test_draw_names_with_dollar_signs_as_they_are(self):
        name = r"a $\frac$ of $2"  # matplotlib refuses it as a formula
        document = synthetic_results.comparison(name)
        for rung in document["ladder"][:2]:
            rung["model"] = [name]
        synthetic_results.write(self.folder, "comparison.json", document)
        for figure in compare_figures.FIGURES.values():
            figure(Comparison(self.folder)).savefig(io.BytesIO())
        document = synthetic_results.diagnosis(name)
        document["ladder"][0]["model"] = document["effects"] = [name]
        document["explanations"][0]["effects"] = [name]
        document["blind_spots"][0]["effect"] = name
        synthetic_results.write(self.folder, "diagnosis.json", document)
        for make_figure in ("error_ladder", "explanations", "blind_spots"):
            figure = diagnose_figures.FIGURES[make_figure](Diagnosis(self.folder))
            figure.savefig(io.BytesIO())


def leaves(part):
    """Container and key of every text and number; only the first item of a list is used."""
    items = part.items() if isinstance(part, dict) else list(enumerate(part))[:1]
    for key, value in list(items):
        if isinstance(value, (dict, list)):
            yield from leaves(value)
        elif value is not None and key not in ("format", "version"):
            yield part, key


if __name__ == "__main__":
    unittest.main()
