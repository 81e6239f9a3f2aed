// SPDX-License-Identifier: BSD-3-Clause
#include "present/files.hpp"

#include "core/user_files.hpp"

namespace culm::present {

void write_json(const std::string& file, const nlohmann::json& json) {
    // Names from damaged or foreign files need not be UTF-8.
    const std::string text =
        json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
    if (file == "-")
        fmt::print("{}", text);
    else
        core::write_text(file, text);
}

} // namespace culm::present
