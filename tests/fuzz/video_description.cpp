// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target: video.toml.
#include "fuzz/fuzz_input.hpp"
#include "measure/track/track.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace culm;
    const auto file = fuzz::write("video.toml", fuzz::text_of(data, size));
    fuzz::may_refuse([&file] { static_cast<void>(measure::read_track_settings(file)); });
    return 0;
}
