// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target: a foreign recording. An input with a line "====" is a mapping and the table that it
// describes, any other one is a C3D file.
#include "fuzz/fuzz_input.hpp"
#include "measure/import/import_recording.hpp"
#include "measure/import/recorded_series.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace culm;
    const std::string input = fuzz::text_of(data, size);
    const std::string border = "\n====\n";
    const std::size_t end = input.find(border);
    if (end == std::string::npos) {
        const auto file = fuzz::write("recording.c3d", input);
        fuzz::may_refuse([&file] { static_cast<void>(measure::read_c3d(file)); });
        return 0;
    }
    const auto mapping = fuzz::write("mapping.toml", std::string_view(input).substr(0, end + 1));
    const auto table =
        fuzz::write("recording.csv", std::string_view(input).substr(end + border.size()));
    fuzz::may_refuse([&] {
        static_cast<void>(measure::import_recording(measure::read_import_mapping(mapping, table)));
    });
    return 0;
}
