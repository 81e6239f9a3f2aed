// SPDX-License-Identifier: BSD-3-Clause
// Writes the example study to the path given, for readers in other languages.
#include "archive/archive_example.hpp"
#include "archive/study/writer.hpp"

#include <exception>
#include <iostream>
#include <span>

int main(int argc, char** argv) {
    using namespace culm::archive;
    const std::span<char*> arguments(argv, static_cast<std::size_t>(argc));
    if (arguments.size() != 2) {
        std::cerr << "usage: write_example_study FILE\n";
        return 2;
    }
    try {
        write_study_file(arguments[1], example::description(), example::design(),
                         [](std::int64_t point) -> std::optional<PointRecord> {
                             if (point == example::missing_point)
                                 return std::nullopt;
                             return example::record_of(point);
                         });
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
    return 0;
}
