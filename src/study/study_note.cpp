// SPDX-License-Identifier: BSD-3-Clause
#include "study/study_note.hpp"

#include "core/error.hpp"
#include "study/study_files.hpp"

#include <cerrno>
#include <fstream>
#include <system_error>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::study {
namespace {

namespace fs = std::filesystem;

constexpr const char* note_format = "culm-journal-note";

nlohmann::ordered_json to_json(const StudyNote& note) {
    nlohmann::ordered_json facts = nlohmann::ordered_json::object();
    for (const auto& [name, text] : note.provenance)
        facts[name] = text;
    return {{"format", note_format}, {"format_version", "1.1"},
            {"name", note.name},     {"points", note.points},
            {"start", note.start},   {"ranks", note.ranks},
            {"provenance", facts},   {"config_file", note.config_file},
            {"config", note.config}, {"config_files", to_text(note.files)}};
}

StudyNote from_json(const nlohmann::ordered_json& json) {
    if (json.at("format") != note_format)
        throw core::StorageError("it is no note of culm");
    StudyNote note{json.at("name"),
                   json.at("points"),
                   json.at("config"),
                   json.at("config_file"),
                   json.at("start"),
                   json.at("ranks"),
                   {},
                   files_from_text(json.value("config_files", std::string()))};
    if (note.points < 0 || note.points > most_points)
        throw core::StorageError(fmt::format("{} points cannot be", note.points));
    for (const auto& [name, text] : json.at("provenance").items())
        note.provenance.emplace_back(name, text.get<std::string>());
    return note;
}

} // namespace

void write_note(const StudyFolder& folder, const StudyNote& note) {
    const fs::path temporary = folder.note().string() + ".tmp";
    std::error_code error;
    fs::create_directories(folder.journals(), error);
    if (!error) {
        std::ofstream out(temporary);
        out << to_json(note).dump(1) << '\n';
        out.flush();
        if (!out) {
            const int reason = errno;
            out.close();
            fs::remove(temporary, error);
            throw core::StorageError(fmt::format("cannot write {}: {}", temporary.string(),
                                                 std::generic_category().message(reason)));
        }
        out.close();
        fs::rename(temporary, folder.note(), error);
    }
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

} // namespace culm::study
