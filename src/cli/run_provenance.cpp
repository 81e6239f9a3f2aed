// SPDX-License-Identifier: BSD-3-Clause
#include "cli/run_provenance.hpp"

#include "archive/bytes.hpp"
#include "cli/version.hpp"
#include "cluster/shell_word.hpp"
#include "core/utc_time.hpp"
#include "physics/effects/selection.hpp"
#include "study/config/study_effects.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <span>

#include <fmt/format.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Name, size and checksum; null where the file cannot be read any more.
json facts_of(const fs::path& path) {
    json facts{{"file", path.string()}, {"bytes", nullptr}, {"crc32", nullptr}};
    std::ifstream file(path, std::ios::binary);
    std::vector<char> block(1U << 20U);
    std::uint64_t bytes = 0;
    std::uint32_t checksum = 0;
    while (file) {
        file.read(block.data(), static_cast<std::streamsize>(block.size()));
        const auto count = static_cast<std::size_t>(file.gcount());
        checksum = archive::crc32(std::as_bytes(std::span(block).first(count)), checksum);
        bytes += count;
    }
    if (file.eof()) {
        facts["bytes"] = bytes;
        facts["crc32"] = fmt::format("{:08x}", checksum);
    }
    return facts;
}

/// Of all threads of this process since it was started, s.
double processor_seconds() {
    std::timespec time{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// To a millisecond.
double rounded(double seconds) {
    return std::round(1e3 * seconds) / 1e3;
}

} // namespace

std::string command_line() {
    std::ifstream file("/proc/self/cmdline", std::ios::binary);
    std::string text;
    for (std::string word; std::getline(file, word, '\0');) {
        if (text.empty())
            word = fs::path(word).filename().string();
        else
            text += ' ';
        text += cluster::shell_word(word);
    }
    return text;
}

std::vector<fs::path> measurement_files(const std::vector<fs::path>& folders) {
    std::vector<fs::path> files;
    for (const fs::path& folder : folders)
        for (const char* name : {measure::stem_file_name, measure::deflection_file_name})
            files.push_back(folder / name);
    return files;
}

std::vector<fs::path> effect_files(const std::string& effects) {
    std::vector<fs::path> files;
    const physics::EffectFileReader read = [&files](const std::string& file) {
        files.emplace_back(file);
        return study::read_effect_file(file);
    };
    static_cast<void>(physics::parse_effects(effects, read));
    return files;
}

RunProvenance::RunProvenance(const std::vector<fs::path>& inputs,
                             const farm::Communicator* communicator)
    : communicator_(communicator), date_(core::utc_now_text()) {
    if (communicator != nullptr && communicator->rank() != 0)
        return;
    std::vector<fs::path> read;
    for (const fs::path& input : inputs)
        if (std::ranges::find(read, input) == read.end()) {
            read.push_back(input);
            inputs_.push_back(facts_of(input));
        }
}

json RunProvenance::document() const {
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
    double processor = processor_seconds();
    int ranks = 1;
    if (communicator_ != nullptr) {
        ranks = communicator_->size();
        const std::vector<std::string> told = communicator_->gather(fmt::format("{}", processor));
        processor = 0.0;
        for (const std::string& seconds : told)
            processor += seconds.empty() ? 0.0 : std::stod(seconds);
    }
    json out = json::object();
    for (const auto& [name, text] : build_provenance())
        out[name] = text;
    out["date"] = date_;
    out["command"] = command_line();
    out["wall_s"] = rounded(wall.count());
    out["processor_s"] = rounded(processor);
    out["ranks"] = ranks;
    out["inputs"] = inputs_;
    return out;
}

} // namespace culm::cli
