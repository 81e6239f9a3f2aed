// SPDX-License-Identifier: BSD-3-Clause
// Pages for man(1), made of what --help knows.
#pragma once

#include <map>
#include <string>

namespace CLI {
class App;
}

namespace culm::cli {

/// A page (roff, man macros) for the program and for every command below it, by file name:
/// "culm.1", "culm-run.1", "culm-archive-verify.1". `version` stands in their feet. Deterministic.
[[nodiscard]] std::map<std::string, std::string> manual_pages(const CLI::App& program,
                                                              const std::string& version);

} // namespace culm::cli
