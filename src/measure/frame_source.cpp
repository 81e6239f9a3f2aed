// SPDX-License-Identifier: BSD-3-Clause
#include "measure/frame_source.hpp"

#include "core/error.hpp"
#include "measure/photron_recording.hpp"
#include "measure/picture_files.hpp"

#include <fmt/core.h>

namespace culm::measure {

std::unique_ptr<FrameSource> open_frames(const std::filesystem::path& folder,
                                         const std::string& location) {
    const std::filesystem::path path = folder / location;
    if (path.filename().string().find('%') != std::string::npos)
        return open_image_sequence(path);
    if (!std::filesystem::is_regular_file(path))
        throw core::InputError(fmt::format(
            "{}: is no file (a numbered image sequence is written like frames/%05d.png)",
            path.string()));
    const std::string extension = path.extension().string();
    if (extension == ".cih" || extension == ".cihx" || extension == ".CIH" || extension == ".CIHX")
        return open_photron(path);
    if (extension == ".mraw" || extension == ".MRAW")
        throw core::InputError(
            fmt::format("{}: give the header that belongs to it (.cih or .cihx)", path.string()));
    return open_video_file(path);
}

} // namespace culm::measure
