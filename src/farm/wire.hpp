// SPDX-License-Identifier: BSD-3-Clause
// Messages as bytes: plain values and texts one after the other, in the order they are written.
#pragma once

#include "farm/farm_error.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace culm::farm {

/// Values travel in their memory layout: all ranks run the same executable on the same
/// architecture.
using Bytes = std::vector<std::byte>;

class WireWriter {
  public:
    template <class T>
    requires std::is_trivially_copyable_v<T> WireWriter& put(const T& value) {
        append(&value, sizeof value);
        return *this;
    }

    WireWriter& put_text(std::string_view text) {
        put(text.size());
        append(text.data(), text.size());
        return *this;
    }

    [[nodiscard]] Bytes take() { return std::move(bytes_); }

  private:
    void append(const void* data, std::size_t size) {
        if (size == 0)
            return;
        const std::size_t old_size = bytes_.size();
        bytes_.resize(old_size + size);
        std::memcpy(bytes_.data() + old_size, data, size);
    }

    Bytes bytes_;
};

/// Reads what a WireWriter wrote. Throws FarmError if the message is too short.
class WireReader {
  public:
    explicit WireReader(Bytes bytes) : bytes_(std::move(bytes)) {}

    template <class T>
    requires std::is_trivially_copyable_v<T>
    void get(T& value) { extract(&value, sizeof value); }

    template <class T>
    [[nodiscard]] T get() {
        T value{};
        get(value);
        return value;
    }

    void get_text(std::string& text) {
        const auto size = get<std::size_t>();
        require(size);
        text.resize(size);
        extract(text.data(), size);
    }

  private:
    void require(std::size_t size) const {
        if (size > bytes_.size() - position_)
            throw FarmError("a message of the farm ends too early");
    }

    void extract(void* data, std::size_t size) {
        require(size);
        if (size == 0)
            return;
        std::memcpy(data, bytes_.data() + position_, size);
        position_ += size;
    }

    Bytes bytes_;
    std::size_t position_ = 0;
};

} // namespace culm::farm
