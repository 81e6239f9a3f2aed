# SPDX-License-Identifier: BSD-3-Clause
"""Tests the layer check: each rule is broken once in a temporary tree."""

import tempfile
import unittest
from pathlib import Path

import layers


class LayerCheck(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        (self.root / "src").mkdir()

    def faults_of(self, name: str, text: str) -> list[str]:
        path = self.root / "src" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return layers.faults(self.root)

    def test_arrows_point_down(self):
        above = set(layers.ALLOWED)
        for layer, below in reversed(layers.ALLOWED.items()):
            above.discard(layer)
            self.assertLessEqual(below, above, f"{layer} sees a later line of the table")

    def test_includes_along_the_arrows_are_accepted(self):
        text = '#include "run/recorder.hpp"\n#include "core/error.hpp"\n#include <vector>\n'
        self.assertEqual(self.faults_of("run/recorder.cpp", text), [])

    def test_an_include_of_a_higher_layer_is_found(self):
        self.assertEqual(
            self.faults_of("physics/chain.hpp", '#pragma once\n#  include "run/case_spec.hpp"\n'),
            ["src/physics/chain.hpp: physics must not include run/case_spec.hpp"],
        )

    def test_a_neighbour_on_the_same_level_is_found(self):
        text = "#include <archive/study_file.hpp>\n"
        self.assertEqual(len(self.faults_of("reduce/a.cpp", text)), 1)

    def test_the_farm_is_for_drivers_of_many_cases_only(self):
        text = '#include "farm/farm.hpp"\n'
        self.assertEqual(self.faults_of("study/execute.cpp", text), [])
        self.assertEqual(len(self.faults_of("run/simulate.cpp", text)), 1)

    def test_a_file_in_a_subfolder_belongs_to_its_layer(self):
        text = '#include "study/a.hpp"\n'
        self.assertEqual(len(self.faults_of("physics/effects/a.hpp", text)), 1)

    def test_a_relative_include_is_found(self):
        self.assertEqual(len(self.faults_of("core/a.cpp", '#include "../run/simulate.hpp"\n')), 1)

    def test_library_headers_outside_their_layer_are_found(self):
        for header in ("mpi.h", "hdf5.h", "H5FDdevelop.h", "sundials/sundials_context.h",
                       "arkode/arkode_arkstep.h", "cvodes/cvodes.h", "kinsol/kinsol.h",
                       "nvector/nvector_serial.h", "opencv2/core.hpp"):
            with self.subTest(header):
                self.assertEqual(len(self.faults_of("study/a.cpp", f"#include <{header}>\n")), 1)

    def test_library_headers_inside_their_layer_are_accepted(self):
        self.assertEqual(self.faults_of("farm/a.cpp", "#include <mpi.h>\n"), [])
        self.assertEqual(self.faults_of("archive/a.cpp", "#include <hdf5.h>\n"), [])

    def test_a_library_may_belong_to_a_part_of_a_layer(self):
        text = "#include <cvode/cvode.h>\n"
        self.assertEqual(self.faults_of("integrate/sundials/a.cpp", text), [])
        text = "#include <opencv2/core.hpp>\n"
        self.assertEqual(self.faults_of("measure/track/a.cpp", text), [])
        self.assertEqual(self.faults_of("measure/folder/a.cpp", text),
                         ["src/measure/folder/a.cpp: OpenCV (opencv2/core.hpp) belongs to "
                          "measure/track"])

    def test_a_link_to_a_higher_layer_is_found(self):
        self.assertEqual(
            self.faults_of("core/CMakeLists.txt", "culm_add_layer(core LINKS culm::farm)\n"),
            ["src/core/CMakeLists.txt: core must not link culm::farm"],
        )

    def test_a_link_to_a_foreign_library_is_found(self):
        text = "culm_add_layer(run LINKS culm::core SUNDIALS::arkode_shared) # not MPI::MPI_C\n"
        self.assertEqual(
            self.faults_of("run/CMakeLists.txt", text),
            ["src/run/CMakeLists.txt: SUNDIALS belongs to integrate/sundials"],
        )

    def test_an_unknown_layer_is_found(self):
        self.assertEqual(len(self.faults_of("tools/a.cpp", "\n")), 1)


if __name__ == "__main__":
    unittest.main()
