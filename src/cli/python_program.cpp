// SPDX-License-Identifier: BSD-3-Clause
#include "cli/python_program.hpp"

#include "cli/provenance.hpp"
#include "core/error.hpp"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include <fmt/core.h>
#include <unistd.h>

namespace culm::cli {

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

} // namespace culm::cli
