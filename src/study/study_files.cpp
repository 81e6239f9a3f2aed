// SPDX-License-Identifier: BSD-3-Clause
#include "study/study_files.hpp"

#include "core/error.hpp"
#include "core/file_text.hpp"
#include "core/named_path.hpp"

#include <nlohmann/json.hpp>

namespace culm::study {

const std::string& text_of_named_file(ConfigContext& context, const std::string& name) {
    StudyFiles& used = context.config.files;
    const auto given = context.files.find(name);
    if (given != context.files.end())
        return used.insert_or_assign(name, given->second).first->second;
    std::string text = core::file_text(core::path_named_in(context.config.file, name));
    return used.insert_or_assign(name, std::move(text)).first->second;
}

std::string to_text(const StudyFiles& files) {
    nlohmann::json object = nlohmann::json::object();
    for (const auto& [name, text] : files)
        object[name] = text;
    // A file that is not UTF-8 cannot be repeated from the archive, but must not stop the study.
    return object.dump(1, ' ', false, nlohmann::json::error_handler_t::replace);
}

StudyFiles files_from_text(const std::string& text) {
    StudyFiles files;
    if (text.empty())
        return files;
    try {
        const nlohmann::json object = nlohmann::json::parse(text);
        for (const auto& [name, content] : object.items())
            files.emplace(name, content.get<std::string>());
    } catch (const nlohmann::json::exception& error) {
        throw core::InputError(std::string("the archived texts of the study's files: ") +
                               error.what());
    }
    return files;
}

} // namespace culm::study
