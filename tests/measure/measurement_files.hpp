// SPDX-License-Identifier: BSD-3-Clause
// Measurement folders for tests.
#pragma once

#include "measure/folder/measurement_folder.hpp"
#include "measure/refused_text.hpp"
#include "support/temporary_folder.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace culm::tests {

inline const std::string plain_stem = "[stem]\nid = \"A\"\nlength_mm = 157.0\ndiameter_mm = 2.83\n"
                                      "density_kg_m3 = 125.0\n";
inline const std::string plain_table = "time_s,h=14mm,h=148mm\n-0.001,0.182,17.6\n0,0.18,17.5\n"
                                       "0.001,0.17,\n";

inline void write_file(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

[[nodiscard]] inline std::string file_text(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// A folder with these two files.
[[nodiscard]] inline measure::Measurement read_texts(const std::string& stem,
                                                     const std::string& table) {
    const TemporaryFolder folder;
    write_file(folder / measure::stem_file_name, stem);
    write_file(folder / measure::deflection_file_name, table);
    return measure::read_measurement(folder.path());
}

/// The refusal of such a folder, with the temporary path cut away.
[[nodiscard]] inline std::string refusal_of(const std::string& stem, const std::string& table) {
    const TemporaryFolder folder;
    write_file(folder / measure::stem_file_name, stem);
    write_file(folder / measure::deflection_file_name, table);
    std::string text =
        refusal([&] { static_cast<void>(measure::read_measurement(folder.path())); });
    const std::string prefix = folder.path().string() + "/";
    for (std::size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix))
        text.erase(at, prefix.size());
    return text;
}

[[nodiscard]] inline std::string refusal_of_table(const std::string& table) {
    return refusal_of(plain_stem, table);
}

} // namespace culm::tests
