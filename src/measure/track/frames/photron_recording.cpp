// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "core/user_files.hpp"
#include "measure/folder/delimited_text.hpp"
#include "measure/track/frames/frame_source.hpp"
#include "measure/track/frames/parallel_frames.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <string_view>

#include <fmt/core.h>

namespace culm::measure {

namespace {

/// Entries by their name in a .cih file.
using Entries = std::map<std::string, std::string, std::less<>>;

/// Lines "Name : value". Sections about the viewer program follow the camera's section after a
/// blank line and repeat names, so the first entry of a name is used.
Entries entries_of_cih(const std::string& text) {
    Entries entries;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (const std::size_t colon = line.find(" : "); colon != std::string::npos)
            entries.emplace(trimmed(line.substr(0, colon)), trimmed(line.substr(colon + 3)));
    return entries;
}

/// Text of the first <name> inside `xml`; empty if there is none.
std::string_view element(std::string_view xml, const std::string& name) {
    const std::size_t begin = xml.find("<" + name + ">");
    if (begin == std::string_view::npos)
        return {};
    const std::size_t content = begin + name.size() + 2;
    const std::size_t end = xml.find("</" + name + ">", content);
    return end == std::string_view::npos ? std::string_view{} : xml.substr(content, end - content);
}

/// The XML header of newer cameras, under the names that the older one uses. Of several elements
/// for a name the first that has a text is used.
Entries entries_of_cihx(const std::string& text) {
    static const std::vector<std::pair<const char*, std::vector<const char*>>> paths{
        {"Record Rate(fps)", {"recordInfo", "recordRate"}},
        {"Total Frame", {"frameInfo", "totalFrame"}},
        {"Recorded Frame", {"frameInfo", "recordedFrame"}},
        {"Save Step", {"frameInfo", "skipFrame"}},
        {"Save Step", {"frameInfo", "saveStep"}},
        {"Save Step", {"frameInfo", "saveSkip"}},
        {"Save Step", {"frameInfo", "frameStep"}},
        {"Image Width", {"imageDataInfo", "resolution", "width"}},
        {"Image Height", {"imageDataInfo", "resolution", "height"}},
        {"EffectiveBit Depth", {"imageDataInfo", "effectiveBit", "depth"}},
        {"EffectiveBit Side", {"imageDataInfo", "effectiveBit", "side"}},
        {"Color Bit", {"imageDataInfo", "colorInfo", "bit"}},
        {"Color Type", {"imageDataInfo", "colorInfo", "type"}},
        {"File Format", {"imageFileInfo", "fileFormat"}},
    };
    Entries entries;
    const std::string_view root = element(text, "cih");
    for (const auto& [name, path] : paths) {
        std::string_view value = root;
        for (const char* part : path)
            value = element(value, part);
        if (!trimmed(value).empty())
            entries.emplace(name, trimmed(value));
    }
    return entries;
}

class HeaderReader {
  public:
    HeaderReader(std::string file, Entries entries)
        : file_(std::move(file)), entries_(std::move(entries)) {}

    [[nodiscard]] std::string text(const char* name, const char* otherwise) const {
        const auto found = entries_.find(name);
        return found == entries_.end() ? otherwise : found->second;
    }
    /// Required unless `otherwise` is given.
    [[nodiscard]] double number(const char* name, double lowest, double highest,
                                std::optional<double> otherwise = std::nullopt) const {
        const auto found = entries_.find(name);
        if (found == entries_.end()) {
            if (otherwise)
                return *otherwise;
            throw core::InputError(fmt::format("{}: has no entry \"{}\"", file_, name));
        }
        const std::string& value = found->second;
        double result = 0.0;
        const auto [end, error] =
            std::from_chars(value.data(), value.data() + value.size(), result);
        if (error != std::errc{} || end != value.data() + value.size() || !(result >= lowest) ||
            !(result <= highest))
            refuse(name, fmt::format("must be a number from {} to {}", lowest, highest));
        return result;
    }
    [[nodiscard]] int whole(const char* name, int lowest, int highest,
                            std::optional<double> otherwise = std::nullopt) const {
        const double value = number(name, lowest, highest, otherwise);
        if (value != std::floor(value))
            refuse(name, fmt::format("must be a whole number from {} to {}", lowest, highest));
        return static_cast<int>(value);
    }
    [[noreturn]] void refuse(const char* name, const std::string& allowed) const {
        throw core::InputError(
            fmt::format("{}: {} : {}: {}", file_, name, text(name, "(nothing)"), allowed));
    }

  private:
    std::string file_;
    Entries entries_;
};

/// n if every n-th recorded frame was saved. A header that states no step, but several times as
/// many recorded as saved frames, may be of a part of the recording or of every n-th frame.
int save_step_of(const HeaderReader& reader, int frames) {
    const int step = reader.whole("Save Step", 0, 1 << 30, 0);
    const int recorded = reader.whole("Recorded Frame", 1, 1 << 30, frames);
    if (step == 0 && recorded >= 2 * frames)
        reader.refuse(
            "Recorded Frame",
            fmt::format("{} frames of these are in the file, and no entry states the step "
                        "between saved frames: add <skipFrame>1</skipFrame> to <frameInfo> "
                        "if they follow each other, or the step",
                        frames));
    return std::max(step, 1);
}

class PhotronRecording final : public FrameSource {
  public:
    explicit PhotronRecording(const std::filesystem::path& header_file)
        : header_(read_photron_header(header_file)), raw_(raw_file_of(header_file)) {
        const auto size = std::filesystem::file_size(raw_);
        const std::size_t whole = size / header_.bytes_per_frame();
        if (whole < static_cast<std::size_t>(header_.frames))
            throw core::InputError(fmt::format(
                "{}: holds {} whole frames of {} x {} pixels with {} bits; {} promises {}",
                raw_.string(), whole, header_.width, header_.height, header_.bits_per_pixel,
                header_file.filename().string(), header_.frames));
        name_ = raw_.string();
        for (int i = 0; i < header_.frames; ++i)
            numbers_.push_back(i);
        stated_fps_ = header_.frames_per_second();
        states_camera_rate_ = true;
        if (header_.save_step != 1)
            remarks_.push_back(
                fmt::format("the header says that one in {} frames recorded at {} frames/s was "
                            "saved: {} frames/s",
                            header_.save_step, header_.record_rate, header_.frames_per_second()));
    }

    void for_each(std::span<const std::size_t> wanted, int threads, const Use& use) const override {
        for_each_index(wanted.size(), threads, [&](std::size_t i) {
            // Each frame has its own stream, because threads must not share a file position.
            std::vector<std::uint8_t> bytes(header_.bytes_per_frame());
            std::ifstream stream(raw_, std::ios::binary);
            stream.seekg(static_cast<std::streamoff>(wanted[i] * bytes.size()));
            stream.read(reinterpret_cast<char*>(bytes.data()),
                        static_cast<std::streamsize>(bytes.size()));
            if (!stream)
                throw core::InputError(
                    fmt::format("{}: frame {} cannot be read", raw_.string(), wanted[i]));
            use(i, unpack_photron(header_, bytes));
        });
    }

  private:
    static std::filesystem::path raw_file_of(std::filesystem::path header_file) {
        const std::string name = header_file.string();
        for (const char* extension : {".mraw", ".MRAW", ".raw"})
            if (std::filesystem::exists(header_file.replace_extension(extension)))
                return header_file;
        throw core::InputError(
            fmt::format("{}: no .mraw file with this name is in the same folder", name));
    }

    PhotronHeader header_;
    std::filesystem::path raw_;
};

} // namespace

PhotronHeader read_photron_header(const std::filesystem::path& file) {
    const std::string text = core::file_text(file);
    const bool is_xml = lower_case(file.extension().string()) == ".cihx";
    const HeaderReader reader(file.string(), is_xml ? entries_of_cihx(text) : entries_of_cih(text));

    PhotronHeader header;
    header.width = reader.whole("Image Width", 1, 1 << 16);
    header.height = reader.whole("Image Height", 1, 1 << 16);
    header.frames = reader.whole("Total Frame", 1, 1 << 30);
    header.record_rate = reader.number("Record Rate(fps)", 1e-3, 1e8);
    header.save_step = save_step_of(reader, header.frames);
    header.bits_per_pixel = reader.whole("Color Bit", 1, 64);
    header.effective_bits = reader.whole("EffectiveBit Depth", 1, 16, header.bits_per_pixel);
    const std::string side = lower_case(reader.text("EffectiveBit Side", "Lower"));
    if (side != "lower" && side != "higher")
        reader.refuse("EffectiveBit Side", "must be Lower or Higher");
    header.is_high_aligned = side == "higher";
    if (lower_case(reader.text("File Format", "MRaw")) != "mraw")
        reader.refuse("File Format", "must be MRaw (of an image sequence, give the pictures)");
    if (lower_case(reader.text("Color Type", "Mono")).starts_with("color"))
        reader.refuse("Color Type", "must be Mono; export colour recordings as PNG or TIFF");
    if (header.bits_per_pixel != 8 && header.bits_per_pixel != 10 && header.bits_per_pixel != 12 &&
        header.bits_per_pixel != 16)
        reader.refuse("Color Bit", "must be 8, 10, 12 or 16");
    return header;
}

std::size_t PhotronHeader::bytes_per_frame() const {
    const std::size_t bits = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                             static_cast<std::size_t>(bits_per_pixel);
    return (bits + 7) / 8;
}

FrameImage unpack_photron(const PhotronHeader& header, std::span<const std::uint8_t> bytes) {
    FrameImage frame;
    frame.width = header.width;
    frame.height = header.height;
    frame.values.resize(static_cast<std::size_t>(header.width) *
                        static_cast<std::size_t>(header.height));
    const auto bits = static_cast<unsigned>(header.bits_per_pixel);
    // If pixels are stored with spare bits, the effective bits determine the picture's scale.
    const bool has_room = !header.is_high_aligned && header.effective_bits < header.bits_per_pixel;
    const unsigned scale_bits = has_room ? static_cast<unsigned>(header.effective_bits) : bits;
    const float scale = 255.0F / static_cast<float>((1U << scale_bits) - 1U);
    for (std::size_t p = 0; p < frame.values.size(); ++p) {
        unsigned value = 0;
        if (bits == 8) {
            value = bytes[p];
        } else if (bits == 16) {
            value = bytes[2 * p] | static_cast<unsigned>(bytes[2 * p + 1]) << 8U;
        } else {
            const std::size_t first = p * bits;
            // Ten or twelve bits touch two bytes, or three where the second is shared.
            const std::size_t byte = first / 8;
            const std::array<unsigned, 3> touched{bytes[byte],
                                                  byte + 1 < bytes.size() ? bytes[byte + 1] : 0U,
                                                  byte + 2 < bytes.size() ? bytes[byte + 2] : 0U};
            const unsigned window = touched[0] << 16U | touched[1] << 8U | touched[2];
            value = window >> (24U - bits - static_cast<unsigned>(first % 8)) & ((1U << bits) - 1U);
        }
        frame.values[p] = scale * static_cast<float>(value);
    }
    return frame;
}

std::unique_ptr<FrameSource> open_photron(const std::filesystem::path& header) {
    return std::make_unique<PhotronRecording>(header);
}

} // namespace culm::measure
