// SPDX-License-Identifier: BSD-3-Clause
#include "measure/photron_recording.hpp"

#include "core/error.hpp"
#include "measure/parallel_frames.hpp"

#include <array>
#include <fstream>

#include <fmt/core.h>

namespace culm::measure {
namespace {

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
        for (int i = 0; i < header_.frames; ++i)
            numbers_.push_back(i);
    }

    [[nodiscard]] const std::vector<int>& numbers() const override { return numbers_; }
    [[nodiscard]] std::string name() const override { return raw_.string(); }
    [[nodiscard]] std::optional<double> stated_fps() const override {
        return header_.frames_per_second();
    }
    [[nodiscard]] bool states_camera_rate() const override { return true; }
    [[nodiscard]] std::vector<std::string> remarks() const override {
        if (header_.save_step == 1)
            return {};
        return {fmt::format("the header says that one in {} frames recorded at {} frames/s was "
                            "saved: {} frames/s",
                            header_.save_step, header_.record_rate, header_.frames_per_second())};
    }

    void for_each(std::span<const std::size_t> wanted, int threads, const Use& use) const override {
        for_each_index(wanted.size(), threads, [&](std::size_t i) {
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
            fmt::format("{}: no .mraw file with this name lies beside it", name));
    }

    PhotronHeader header_;
    std::filesystem::path raw_;
    std::vector<int> numbers_;
};

} // namespace

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
    // Of pixels stored with room to spare only the effective bits carry the picture's scale.
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
