// SPDX-License-Identifier: BSD-3-Clause
#include "cli/provenance.hpp"

#include "archive/bytes.hpp"
#include "cli/build_facts.hpp"
#include "cluster/batch_system.hpp"
#include "core/error.hpp"
#include "core/lanes.hpp"
#include "core/utc_time.hpp"
#include "integrate/sundials/integrator.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "physics/effects/selection.hpp"
#include "study/config/study_effects.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <span>
#include <system_error>

#include <Eigen/Core>
#include <ceres/version.h>
#include <fmt/format.h>
#include <unistd.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;

/// Name, size and checksum; the last two are empty if the file can no longer be read.
present::InputFile facts_of(const fs::path& path) {
    present::InputFile facts{path.string(), {}, {}};
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
        facts.bytes = bytes;
        facts.crc32 = fmt::format("{:08x}", checksum);
    }
    return facts;
}

/// Processor time of all threads of this process since its start, s.
double processor_seconds() {
    std::timespec time{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// The command line of this process, quoted for a shell.
std::string command_line() {
    std::ifstream file("/proc/self/cmdline", std::ios::binary);
    std::string text;
    for (std::string word; std::getline(file, word, '\0');)
        text += text.empty() ? cluster::shell_word(fs::path(word).filename().string())
                             : ' ' + cluster::shell_word(word);
    return text;
}

/// How this program was built; the other members are empty.
present::Provenance built_program() {
    present::Provenance built;
    built.version = version_text();
    built.compiler = fmt::format("g++ {}", __VERSION__);
    built.build =
        fmt::format("{}, -march={}, {} SIMD lanes", build_type, architecture, core::lane_count);
    built.libraries =
        fmt::format("Eigen {}.{}.{}, Ceres {}, SUNDIALS {}, HDF5 {}, {}", EIGEN_WORLD_VERSION,
                    EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION, CERES_VERSION_STRING,
                    integrate::sundials_version(), hdf5_version, mpi_version);
    return built;
}

/// Rounded to a millisecond.
double rounded(double seconds) {
    return std::round(1e3 * seconds) / 1e3;
}

} // namespace

std::string version_text() {
    return fmt::format("culm {} ({})", version_number, commit);
}

std::vector<std::pair<std::string, std::string>> build_provenance() {
    const present::Provenance build = built_program();
    return {{"version", build.version},
            {"compiler", build.compiler},
            {"build", build.build},
            {"libraries", build.libraries}};
}

fs::path beside_own_program(const std::string& place) {
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    if (error)
        throw core::StorageError(place + ": the system does not report the location "
                                         "of culm (/proc/self/exe), next to which it belongs");
    return (program.parent_path() / place).lexically_normal();
}

void run_python_program(const std::string& name, const std::vector<std::string>& arguments,
                        const std::string& needs) {
    // As installed, or linked into a build tree.
    const std::filesystem::path program = beside_own_program("../share/culm/postprocess/" + name);
    if (!std::filesystem::exists(program))
        throw core::StorageError(fmt::format(
            "{}: is not there; this program belongs to culm's installation", program.string()));
    const char* named = std::getenv("CULM_PYTHON");
    std::vector<std::string> words = {named != nullptr && *named != '\0' ? named : "python3", "-B",
                                      program.string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (std::string& word : words)
        argv.push_back(word.data());
    argv.push_back(nullptr);
    std::fflush(nullptr);
    ::execvp(argv.front(), argv.data());
    throw core::StorageError(fmt::format("{}: cannot be run: {}; {} (the variable CULM_PYTHON "
                                         "names another Python)",
                                         words.front(), std::strerror(errno), needs));
}

std::vector<fs::path> measurement_files(const std::vector<fs::path>& folders) {
    std::vector<fs::path> files;
    for (const fs::path& folder : folders) {
        for (const char* name : {measure::stem_file_name, measure::deflection_file_name})
            files.push_back(folder / name);
        if (fs::is_regular_file(folder / measure::uncertainty_file_name))
            files.push_back(folder / measure::uncertainty_file_name);
    }
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

present::Provenance RunProvenance::document() const {
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
    present::Provenance document = built_program();
    document.date = date_;
    document.command = command_line();
    document.wall_seconds = rounded(wall.count());
    document.processor_seconds = processor_seconds();
    document.inputs = inputs_;
    if (communicator_ != nullptr) {
        document.ranks = communicator_->size();
        document.processor_seconds = 0.0;
        for (const std::string& seconds :
             communicator_->gather(fmt::format("{}", processor_seconds())))
            document.processor_seconds += seconds.empty() ? 0.0 : std::stod(seconds);
    }
    document.processor_seconds = rounded(document.processor_seconds);
    return document;
}

} // namespace culm::cli
