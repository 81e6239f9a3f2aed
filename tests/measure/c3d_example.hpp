// SPDX-License-Identifier: BSD-3-Clause
// Writes small C3D files, so that the tests of the reader need no recording.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace culm::tests {

struct C3dExample {
    bool is_real = true;
    float scale = 0.01F; ///< of integers
    float rate = 200.0F;
    std::vector<std::string> labels{"base", "tip"};
    std::size_t frames = 3;
    std::vector<float> positions; ///< (frames, markers, 3)
    std::vector<bool> seen;       ///< (frames, markers); empty: all
    int analog_words = 0;         ///< per frame
    std::optional<float> used;    ///< POINT:USED as a real; empty: the number of labels

    [[nodiscard]] std::string bytes() const;

  private:
    void put_word(std::string& out, unsigned value) const {
        const char low = static_cast<char>(value & 0xFFU);
        const char high = static_cast<char>(value >> 8U & 0xFFU);
        out += low;
        out += high;
    }
    void put_real(std::string& out, float value) const {
        const auto bits = std::bit_cast<std::uint32_t>(value);
        put_word(out, bits & 0xFFFFU);
        put_word(out, bits >> 16U);
    }
    void put_number(std::string& out, float value) const {
        if (is_real)
            put_real(out, value);
        else
            put_word(out, static_cast<std::uint16_t>(static_cast<std::int16_t>(value)));
    }
    void put_parameter(std::string& out, const std::string& name, int type,
                       const std::vector<int>& dimensions, const std::string& data) const {
        out += static_cast<char>(name.size());
        out += static_cast<char>(1);
        out += name;
        put_word(out, static_cast<unsigned>(5 + dimensions.size() + data.size()));
        out += static_cast<char>(type);
        out += static_cast<char>(dimensions.size());
        for (const int dimension : dimensions)
            out += static_cast<char>(dimension);
        out += data;
        out += '\0'; // no description
    }
};

inline std::string C3dExample::bytes() const {
    const auto padded = [](std::string text) {
        text.resize((text.size() + 511) / 512 * 512, '\0');
        return text;
    };
    const auto real = [&](float value) {
        std::string data;
        put_real(data, value);
        return data;
    };
    const auto word = [&](std::size_t value) {
        std::string data;
        put_word(data, static_cast<unsigned>(value));
        return data;
    };
    std::string header("\x02\x50", 2);
    header += word(labels.size()) + word(static_cast<std::size_t>(analog_words)) + word(1) +
              word(frames) + word(0) + real(is_real ? -scale : scale) + word(3) +
              word(static_cast<std::size_t>(analog_words)) + real(rate);
    std::string parameters("\x01\x50\x01", 3);
    parameters += static_cast<char>(84) /* Intel */;
    parameters += std::string("\x05\xFF", 2) + "POINT";
    put_word(parameters, 3);
    parameters += '\0';
    if (used)
        put_parameter(parameters, "USED", 4, {}, real(*used));
    else
        put_parameter(parameters, "USED", 2, {}, word(labels.size()));
    put_parameter(parameters, "SCALE", 4, {}, real(is_real ? -scale : scale));
    put_parameter(parameters, "RATE", 4, {}, real(rate));
    put_parameter(parameters, "DATA_START", 2, {}, word(3));
    put_parameter(parameters, "UNITS", -1, {4}, "mm  ");
    std::string names;
    for (std::string label : labels) {
        label.resize(8, ' ');
        names += label;
    }
    put_parameter(parameters, "LABELS", -1, {8, static_cast<int>(labels.size())}, names);
    parameters += std::string(2, '\0');
    std::string data;
    for (std::size_t i = 0; i < frames; ++i) {
        for (std::size_t k = 0; k < labels.size(); ++k) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                put_number(data, positions[(i * labels.size() + k) * 3 + axis] /
                                     (is_real ? 1.0F : scale));
            put_number(data, seen.empty() || seen[i * labels.size() + k] ? 0.0F : -1.0F);
        }
        for (int k = 0; k < analog_words; ++k)
            put_number(data, 7.0F);
    }
    return padded(header) + padded(parameters) + padded(data);
}

} // namespace culm::tests
