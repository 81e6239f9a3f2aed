// SPDX-License-Identifier: BSD-3-Clause
#include "cli/version.hpp"

#include "cli/build_facts.hpp"
#include "core/lanes.hpp"

#include <Eigen/Core>
#include <ceres/version.h>
#include <fmt/core.h>

namespace culm::cli {

std::string version_text() {
    return fmt::format("culm {} ({})", version_number, commit);
}

std::vector<std::pair<std::string, std::string>> build_provenance() {
    return {{"version", version_text()},
            {"compiler", fmt::format("g++ {}", __VERSION__)},
            {"build", fmt::format("{}, -march={}, {} SIMD lanes", build_type, architecture,
                                  core::lane_count)},
            {"libraries",
             fmt::format("Eigen {}.{}.{}, Ceres {}, SUNDIALS {}, HDF5 {}, {}", EIGEN_WORLD_VERSION,
                         EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION, CERES_VERSION_STRING,
                         sundials_version, hdf5_version, mpi_version)}};
}

} // namespace culm::cli
