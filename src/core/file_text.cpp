// SPDX-License-Identifier: BSD-3-Clause
#include "core/file_text.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>

namespace culm::core {

namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& reason) {
    throw InputError(file.string() + ": cannot be read: " + reason);
}

} // namespace

std::string file_text(const std::filesystem::path& file, std::size_t largest) {
    std::error_code ignored; // a file that is not there is no folder either
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

} // namespace culm::core
