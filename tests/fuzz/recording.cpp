// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target: a foreign recording. The part before a line "====" is a mapping, the rest is the
// table that it describes.
#include "fuzz/fuzz_input.hpp"
#include "measure/import/import_recording.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace culm;
    const std::string input = fuzz::text_of(data, size);
    const std::string border = "\n====\n";
    const std::size_t end = input.find(border);
    if (end == std::string::npos)
        return 0;
    const auto mapping = fuzz::write("mapping.toml", std::string_view(input).substr(0, end + 1));
    const auto table =
        fuzz::write("recording.csv", std::string_view(input).substr(end + border.size()));
    fuzz::may_refuse([&] {
        static_cast<void>(measure::import_recording(measure::read_import_mapping(mapping, table)));
    });
    return 0;
}
