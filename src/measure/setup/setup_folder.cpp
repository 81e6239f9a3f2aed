// SPDX-License-Identifier: BSD-3-Clause
#include "measure/setup/setup_folder.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <system_error>

#include <fmt/core.h>

namespace culm::measure {
namespace {

namespace fs = std::filesystem;

/// "run_%04d.png" for "run_0007.png"; empty if the name has no number before its suffix.
std::string pattern_of(const std::string& name) {
    const std::string stem = fs::path(name).stem().string();
    std::size_t begin = stem.size();
    while (begin > 0 && std::isdigit(static_cast<unsigned char>(stem[begin - 1])) != 0)
        --begin;
    if (begin == stem.size())
        return {};
    const std::string digits = stem.substr(begin);
    const std::string form =
        digits.front() == '0' && digits.size() > 1 ? fmt::format("%0{}d", digits.size()) : "%d";
    return stem.substr(0, begin) + form + fs::path(name).extension().string();
}

/// The pattern of most pictures of the folder.
std::string sequence_in(const fs::path& folder) {
    std::map<std::string, std::size_t> patterns;
    for (const auto& entry : fs::directory_iterator(folder)) {
        static constexpr std::array suffixes{".png", ".tif", ".tiff", ".jpg", ".jpeg",
                                             ".bmp", ".pgm", ".ppm",  ".webp"};
        std::string suffix = entry.path().extension().string();
        std::ranges::transform(suffix, suffix.begin(), [](unsigned char letter) {
            return static_cast<char>(std::tolower(letter));
        });
        if (std::ranges::find(suffixes, suffix) != suffixes.end())
            if (const std::string pattern = pattern_of(entry.path().filename().string());
                !pattern.empty())
                ++patterns[pattern];
    }
    const auto most =
        std::ranges::max_element(patterns, {}, [](const auto& counted) { return counted.second; });
    if (most == patterns.end())
        throw core::InputError(fmt::format("{}: the folder has no numbered pictures; name a video "
                                           "file, a Photron header (.cih) or a pattern like "
                                           "frames/%05d.png",
                                           folder.string()));
    return most->first;
}

void make_link(const fs::path& target, const fs::path& link) {
    std::error_code error;
    if (fs::exists(fs::symlink_status(link, error))) {
        if (fs::equivalent(link, target, error))
            return;
        throw core::InputError(fmt::format("{} is there already and is not {}; choose another "
                                           "folder with -o",
                                           link.string(), target.string()));
    }
    fs::create_directory_symlink(target, link, error);
    if (error)
        throw core::StorageError(
            fmt::format("{}: a link cannot be made: {}", link.string(), error.message()));
}

} // namespace

std::string recording_location(const std::string& named) {
    std::error_code error;
    if (fs::is_directory(named, error))
        return (fs::path(named) / sequence_in(named)).string();
    const std::string name = fs::path(named).filename().string();
    if (name.find('%') == std::string::npos && !fs::exists(named, error))
        throw core::InputError(fmt::format("{}: there is no such file or folder", named));
    return named;
}

std::string make_setup_folder(const fs::path& folder, const std::string& location) {
    if (const fs::path file = folder / "video.toml"; fs::exists(fs::symlink_status(file)))
        throw core::InputError(fmt::format("{} is there already; choose another folder with -o or "
                                           "remove it",
                                           file.string()));
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
        throw core::StorageError(
            fmt::format("cannot create the folder {}: {}", folder.string(), error.message()));
    const fs::path recording = fs::absolute(location);
    const fs::path pictures = fs::canonical(recording.parent_path(), error);
    if (error)
        throw core::InputError(fmt::format("{}: {}", location, error.message()));
    const std::string inside = pictures.lexically_relative(fs::canonical(folder)).string();
    if (!inside.starts_with("..") && !inside.empty())
        return (fs::path(inside) / recording.filename()).lexically_normal().string();
    make_link(pictures, folder / "frames");
    return (fs::path("frames") / recording.filename()).string();
}

} // namespace culm::measure
