// SPDX-License-Identifier: BSD-3-Clause
#include "study/pace_file.hpp"

#include "farm/communicator.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include <nlohmann/json.hpp>

namespace culm::study {
namespace {

namespace fs = std::filesystem;

constexpr const char* pace_format = "culm-pace";

bool is_sound(const farm::Pace& pace) {
    return std::isfinite(pace.cost) && std::isfinite(pace.seconds) && std::isfinite(pace.squares) &&
           pace.cost > 0.0 && pace.seconds > 0.0 && pace.squares > 0.0;
}

} // namespace

farm::Pace read_pace(const StudyFolder& folder) {
    std::ifstream in(folder.pace());
    const auto json = nlohmann::json::parse(in, nullptr, false);
    try {
        if (json.at("format") != pace_format)
            return {};
        const farm::Pace pace{json.at("estimated_seconds"), json.at("seconds"),
                              json.at("seconds_squared_per_estimated_second")};
        return is_sound(pace) ? pace : farm::Pace{};
    } catch (const nlohmann::json::exception&) {
        return {};
    }
}

void write_pace(const StudyFolder& folder, const farm::Pace& pace) {
    std::error_code error;
    if (!is_sound(pace) || !fs::is_directory(folder.journals(), error))
        return;
    const fs::path temporary = folder.pace().string() + ".tmp";
    const nlohmann::ordered_json json = {{"format", pace_format},
                                         {"format_version", "1.0"},
                                         {"estimated_seconds", pace.cost},
                                         {"seconds", pace.seconds},
                                         {"seconds_squared_per_estimated_second", pace.squares}};
    std::ofstream out(temporary);
    out << json.dump(1) << '\n';
    out.close();
    if (out)
        fs::rename(temporary, folder.pace(), error);
    else
        fs::remove(temporary, error);
}

farm::Pace earlier_pace(const StudyFolder& folder, const std::vector<farm::Batch>& batches,
                        const farm::Communicator* communicator) {
    const farm::Pace pace = farm::on_root(communicator, [&] { return read_pace(folder); });
    double longest = 0.0;
    for (const farm::Batch& batch : batches)
        longest = std::max(longest, batch.cost);
    const int ranks = communicator == nullptr ? 1 : communicator->size();
    return pace.with_weight_up_to(longest * ranks);
}

double shortest_expected_time(const std::vector<farm::Batch>& batches, const farm::Pace& pace) {
    if (batches.empty())
        return 0.0;
    const double cost =
        std::ranges::min(batches, {}, [](const farm::Batch& batch) { return batch.cost; }).cost;
    return cost * (pace.is_known() ? pace.cautious() : 1.0);
}

} // namespace culm::study
