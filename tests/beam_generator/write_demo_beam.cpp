// SPDX-License-Identifier: BSD-3-Clause
// Prints tests/data/demo-beam/axis.csv.
#include "beam_generator/demo_beam.hpp"

#include <cstdio>
#include <string>

int main() {
    const std::string table = culm::beam::demo_axis_table();
    return std::fputs(table.c_str(), stdout) < 0 ? 1 : 0;
}
