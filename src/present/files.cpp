// SPDX-License-Identifier: BSD-3-Clause
#include "present/files.hpp"

#include "core/user_files.hpp"

namespace culm::present {

nlohmann::json sample_json(const reduce::SampleSummary& sample, double scale) {
    return {{"mean", number(scale * sample.mean)},
            {"mean_interval", bounds_json(sample.mean_interval, scale)},
            {"standard_deviation", number(scale * sample.standard_deviation)},
            {"standard_deviation_interval", bounds_json(sample.standard_deviation_interval, scale)},
            {"lowest", number(scale * sample.lowest)},
            {"median", number(scale * sample.median)},
            {"highest", number(scale * sample.highest)},
            {"central_90_percent", bounds_json(sample.central_90_percent, scale)}};
}

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
