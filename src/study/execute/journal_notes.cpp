// SPDX-License-Identifier: BSD-3-Clause
#include "study/execute/journal_notes.hpp"

#include "core/error.hpp"
#include "farm/communicator.hpp"
#include "study/config/study_config.hpp"

#include <cerrno>
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

nlohmann::ordered_json to_json(const StudyNote& note) {
    const nlohmann::ordered_json::object_t facts(note.provenance.begin(), note.provenance.end());
    return {{"format", note_format}, {"format_version", "1.1"},
            {"name", note.name},     {"points", note.points},
            {"start", note.start},   {"ranks", note.ranks},
            {"provenance", facts},   {"config_file", note.config_file},
            {"config", note.config}, {"config_files", to_text(note.files)}};
}

StudyNote from_json(const nlohmann::ordered_json& json) {
    if (json.at("format") != note_format)
        throw core::StorageError("it is not a note of culm");
    StudyNote note{json.at("name"),
                   json.at("points"),
                   json.at("config"),
                   json.at("config_file"),
                   json.at("start"),
                   json.at("ranks"),
                   {},
                   files_from_text(json.value("config_files", std::string()))};
    if (note.points < 0 || note.points > most_points)
        throw core::StorageError(fmt::format("{} is not a number of points", note.points));
    for (const auto& [name, text] : json.at("provenance").items())
        note.provenance.emplace_back(name, text.get<std::string>());
    return note;
}

/// Replaces a file atomically. Throws StorageError if it cannot be written; `error` is that of the
/// renaming.
void replace_json(const fs::path& file, const nlohmann::ordered_json& json,
                  std::error_code& error) {
    const fs::path temporary = file.string() + ".tmp";
    std::ofstream out(temporary);
    out << json.dump(1) << '\n';
    out.flush();
    if (!out) {
        const int reason = errno;
        out.close();
        fs::remove(temporary, error);
        throw core::StorageError(fmt::format("cannot write {}: {}", temporary.string(),
                                             std::generic_category().message(reason)));
    }
    out.close();
    fs::rename(temporary, file, error);
}

constexpr const char* pace_format = "culm-pace";

bool is_sound(const farm::Pace& pace) {
    return std::isfinite(pace.cost) && std::isfinite(pace.seconds) && std::isfinite(pace.squares) &&
           pace.cost > 0.0 && pace.seconds > 0.0 && pace.squares > 0.0;
}

} // namespace

void write_note(const StudyFolder& folder, const StudyNote& note) {
    std::error_code error;
    fs::create_directories(folder.journals(), error);
    if (!error)
        replace_json(folder.note(), to_json(note), error);
    if (error)
        throw core::StorageError(
            fmt::format("cannot write {}: {}", folder.note().string(), error.message()));
}

std::optional<StudyNote> read_note(const StudyFolder& folder) {
    if (!is_there(folder.note()))
        return std::nullopt;
    std::ifstream in(folder.note());
    try {
        return from_json(nlohmann::ordered_json::parse(in));
    } catch (const std::exception& error) {
        throw core::StorageError(
            fmt::format("{} cannot be read: {}", folder.note().string(), error.what()));
    }
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
        replace_json(folder.pace(),
                     {{"format", pace_format},
                      {"format_version", "1.0"},
                      {"estimated_seconds", pace.cost},
                      {"seconds", pace.seconds},
                      {"seconds_squared_per_estimated_second", pace.squares}},
                     error);
    } catch (const core::StorageError&) {
        return;
    }
}

} // namespace culm::study
