// SPDX-License-Identifier: BSD-3-Clause
// Shared by the fuzz targets: input as text, files for it, and the exceptions of a refusal.
#pragma once

#include "core/error.hpp"
#include "support/temporary_folder.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

/// The function that libFuzzer calls with every input, and replay.cpp with every kept one.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace culm::fuzz {

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
    return size == 0 ? std::string() : std::string(reinterpret_cast<const char*>(data), size);
}

/// One folder for all inputs of this process.
inline const std::filesystem::path& folder() {
    static const tests::TemporaryFolder scratch;
    return scratch.path();
}

/// Writes a file into the folder; its path.
inline std::filesystem::path write(const std::string& name, std::string_view bytes) {
    const std::filesystem::path path = folder() / name;
    std::ofstream(path, std::ios::binary | std::ios::trunc)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path;
}

/// A refusal with one of culm's errors is not a finding; any other exception is.
template <class Action>
void may_refuse(const Action& action) {
    try {
        action();
    } catch (const core::InputError&) {
    } catch (const core::StorageError&) {
    } catch (const core::NumericalError&) {
    }
}

} // namespace culm::fuzz
