// SPDX-License-Identifier: BSD-3-Clause
#include "core/user_files.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

namespace culm::core {

namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& reason) {
    throw InputError(file.string() + ": cannot be read: " + reason);
}

} // namespace

std::string file_text(const std::filesystem::path& file, std::size_t largest) {
    std::error_code ignored; // a missing file is not a folder
    if (std::filesystem::is_directory(file, ignored))
        refuse(file, "it is a folder");
    // Streams do not report why they fail; on POSIX systems errno does.
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        refuse(file, std::generic_category().message(errno));
    // Block by block, because a device or a pipe has no size that could be checked beforehand.
    constexpr std::size_t block = std::size_t{1} << 16U;
    std::string text;
    while (stream && text.size() <= largest) {
        const std::size_t before = text.size();
        text.resize(before + block);
        stream.read(text.data() + before, static_cast<std::streamsize>(block));
        text.resize(before + static_cast<std::size_t>(stream.gcount()));
    }
    if (text.size() > largest)
        refuse(file, "it is larger than " + std::to_string(largest >> 20U) + " MiB");
    if (stream.bad())
        refuse(file, std::generic_category().message(errno));
    return text;
}

void require_written(std::ofstream& out, const std::filesystem::path& file) {
    out.close();
    if (!out)
        throw StorageError(fmt::format("{}: cannot be written", file.string()));
}

void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file, std::ios::binary);
    out << text;
    require_written(out, file);
}

void create_folder(const std::filesystem::path& folder) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    if (failed)
        throw StorageError(
            fmt::format("{}: cannot be created: {}", folder.string(), failed.message()));
}

std::string named_path_fault(std::string_view name) {
    const std::filesystem::path path(name);
    if (name.empty())
        return "must be the name of a file";
    if (name.find('\0') != std::string_view::npos)
        return "must not contain a zero byte";
    const std::filesystem::path plain = path.lexically_normal();
    if (path.is_absolute() || (!plain.empty() && *plain.begin() == ".."))
        return "must lie in the folder of the file that names it, or below (a symbolic link there "
               "may lead elsewhere)";
    return "";
}

std::filesystem::path path_named_in(const std::filesystem::path& file, const std::string& name) {
    if (const std::string fault = named_path_fault(name); !fault.empty())
        throw InputError("\"" + name + "\" " + fault);
    return file.parent_path() / name;
}

void FileFaults::add(std::size_t line, std::string_view text) {
    faults_.push_back({line, line == 0 ? fmt::format("{}: {}", file_, text)
                                       : fmt::format("{}:{}: {}", file_, line, text)});
}

void FileFaults::add(std::size_t line, std::string_view key, std::string_view value,
                     std::string_view allowed) {
    add(line, fmt::format("{} = {}: {}", key, value, allowed));
}

void FileFaults::throw_if_any() const {
    if (faults_.empty())
        return;
    constexpr std::size_t most_listed = 12;
    // Readers find faults key by key, a person corrects a file from top to bottom. The sort is
    // stable: faults of one line keep the order in which they were found.
    auto ordered = faults_;
    std::ranges::stable_sort(ordered, {}, &Fault::line);
    std::string text;
    for (std::size_t i = 0; i < std::min(ordered.size(), most_listed); ++i)
        text += (i == 0 ? "" : "\n") + ordered[i].text;
    if (ordered.size() > most_listed)
        text += fmt::format("\n... and {} more faults in {}", ordered.size() - most_listed, file_);
    throw InputError(text);
}

} // namespace culm::core
