// SPDX-License-Identifier: BSD-3-Clause
#include "study/execute/journal_notes.hpp"

#include "core/decimal_text.hpp"
#include "core/error.hpp"
#include "core/user_files.hpp"
#include "farm/communicator.hpp"
#include "study/design/design.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::study {

namespace {

namespace fs = std::filesystem;

constexpr const char* note_format = "culm-journal-note";

/// Replaces a file atomically. Throws StorageError.
void replace_json(const fs::path& file, const nlohmann::ordered_json& json) {
    const fs::path temporary = file.string() + ".tmp";
    std::error_code error;
    core::write_text(temporary, json.dump(1) + '\n');
    fs::rename(temporary, file, error);
    if (error)
        throw core::StorageError(
            fmt::format("cannot write {}: {}", file.string(), error.message()));
}

constexpr const char* pace_format = "culm-pace";

bool is_sound(const farm::Pace& pace) {
    return std::isfinite(pace.cost) && std::isfinite(pace.seconds) && std::isfinite(pace.squares) &&
           pace.cost > 0.0 && pace.seconds > 0.0 && pace.squares > 0.0;
}

} // namespace

void write_note(const StudyFolder& folder, const archive::Texts& note) {
    const nlohmann::ordered_json::object_t texts(note.begin(), note.end());
    core::create_folder(folder.journals());
    replace_json(folder.note(),
                 {{"format", note_format}, {"format_version", "2.0"}, {"study", texts}});
}

std::optional<archive::Texts> read_note(const StudyFolder& folder) {
    if (!is_there(folder.note()))
        return std::nullopt;
    std::ifstream in(folder.note());
    try {
        const auto json = nlohmann::ordered_json::parse(in);
        if (json.at("format") != note_format)
            throw core::StorageError("it is not a note of culm");
        archive::Texts note;
        for (const auto& [name, text] : json.at("study").items())
            note.emplace_back(name, text.get<std::string>());
        static_cast<void>(points_of(note));
        return note;
    } catch (const std::exception& error) {
        throw core::StorageError(
            fmt::format("{} cannot be read: {}", folder.note().string(), error.what()));
    }
}

std::int64_t points_of(const archive::Texts& note) {
    const std::string text = archive::text_named("points", note);
    const double points = core::parse_decimal(text).value_or(-1.0);
    if (!(points >= 0.0 && points <= static_cast<double>(most_points)))
        throw core::StorageError(fmt::format("{} is not a number of points", text));
    return static_cast<std::int64_t>(points);
}

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
    // The pace only improves an estimate, so a failure to store it is not reported.
    if (!is_sound(pace) || !fs::is_directory(folder.journals(), error))
        return;
    try {
        replace_json(folder.pace(), {{"format", pace_format},
                                     {"format_version", "1.0"},
                                     {"estimated_seconds", pace.cost},
                                     {"seconds", pace.seconds},
                                     {"seconds_squared_per_estimated_second", pace.squares}});
    } catch (const core::StorageError&) {
        return;
    }
}

} // namespace culm::study
