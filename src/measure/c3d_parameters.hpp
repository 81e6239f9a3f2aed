// SPDX-License-Identifier: BSD-3-Clause
// The parameter section of a C3D file: named groups of named values.
#pragma once

#include "measure/c3d_bytes.hpp"

#include <map>
#include <string>
#include <vector>

namespace culm::measure {

struct C3dParameter {
    std::vector<double> numbers;    ///< of byte, integer and real parameters, in the file's order
    std::vector<std::string> texts; ///< of character parameters
};

/// "GROUP:NAME" in capitals -> values.
using C3dParameters = std::map<std::string, C3dParameter>;

/// Reads the section that begins at byte `begin`, and sets the processor of `bytes`.
[[nodiscard]] C3dParameters read_c3d_parameters(C3dBytes& bytes, std::size_t begin);

} // namespace culm::measure
