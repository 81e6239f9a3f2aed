// SPDX-License-Identifier: BSD-3-Clause
// By which program, from which files and at what cost a document was made.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace culm::present {

struct InputFile {
    std::string file;
    std::optional<std::uint64_t> bytes; ///< empty, as the checksum: it can no longer be read
    std::optional<std::string> crc32;
};

template <class To>
void describe(To& to, const InputFile& input) {
    to("file", input.file);
    to("bytes", input.bytes);
    to("crc32", input.crc32);
}

struct Provenance {
    std::string version;
    std::string compiler;
    std::string build;
    std::string libraries;
    std::string date;
    std::string command;
    double wall_seconds = 0.0;
    double processor_seconds = 0.0;
    int ranks = 1;
    std::vector<InputFile> inputs;
};

template <class To>
void describe(To& to, const Provenance& provenance) {
    to("version", provenance.version);
    to("compiler", provenance.compiler);
    to("build", provenance.build);
    to("libraries", provenance.libraries);
    to("date", provenance.date, "of the beginning, UTC");
    to("command", provenance.command);
    to("wall_s", provenance.wall_seconds);
    to("processor_s", provenance.processor_seconds, "of all ranks");
    to("ranks", provenance.ranks);
    to("inputs", provenance.inputs);
}

} // namespace culm::present
