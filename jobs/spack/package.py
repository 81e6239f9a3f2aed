# SPDX-License-Identifier: BSD-3-Clause
"""Spack's recipe: put it into a repository of yours as packages/culm/package.py (docs/install.md)."""

from spack.package import *


class Culm(CMakePackage, PythonExtension):
    """Calibrates a flexible-stem discrete-element model against measured free vibration, and finds
    out which physics the model lacks."""

    license("BSD-3-Clause")
    version("main", branch="main")

    variant("reports", default=True, description="Figures and reports (Python)")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("mpi@3.1:")
    depends_on("eigen@3.4:3")
    depends_on("hdf5@1.10:~mpi")
    depends_on("sundials@6.4:7+ARKODE")
    depends_on("ceres-solver@2.1:2.1")
    depends_on("boost@1.74:")
    depends_on("tomlplusplus@3.3:")
    depends_on("cli11@2.1:2")
    depends_on("muparser@2.3:")
    depends_on("fmt@9:")
    depends_on("nlohmann-json@3.11:")
    depends_on("opencv@4.5:+videoio+imgcodecs+imgproc")
    depends_on("random123@1.14:")
    depends_on("libdeflate@1.8:")
    with when("+reports"):
        extends("python")
        depends_on("python@3.11:", type="run")
        depends_on("py-h5py", type="run")
        depends_on("py-numpy", type="run")
        depends_on("py-matplotlib", type="run")

    conflicts("%gcc@:10")
    conflicts("%clang", msg="lanes use GCC's <experimental/simd>")

    def cmake_args(self):
        return [
            self.define("CULM_BUILD_TESTS", self.run_tests),
            self.define("CULM_WARNINGS_AS_ERRORS", False),
            # The compiler wrapper passes the target's -march.
            self.define("CULM_ARCHITECTURE", ""),
        ]
