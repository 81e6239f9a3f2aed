// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target: a measurement folder. The input is stem.toml, a line "====", deflection.csv.
#include "fuzz/fuzz_input.hpp"
#include "measure/folder/measurement_folder.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace culm;
    const std::string input = fuzz::text_of(data, size);
    const std::string border = "\n====\n";
    const std::size_t end = input.find(border);
    if (end == std::string::npos)
        return -1; // not worth keeping
    fuzz::write("stem.toml", std::string_view(input).substr(0, end + 1));
    fuzz::write("deflection.csv", std::string_view(input).substr(end + border.size()));
    fuzz::may_refuse([] {
        // The writer accepts whatever the reader accepts, and the reader accepts its output; only
        // measurements without sensors are written.
        const measure::Measurement measurement = measure::read_measurement(fuzz::folder());
        if (!measurement.sensors.empty())
            return;
        measure::write_measurement(fuzz::folder() / "again", measurement);
        static_cast<void>(measure::read_measurement(fuzz::folder() / "again"));
    });
    return 0;
}
