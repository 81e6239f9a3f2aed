// SPDX-License-Identifier: BSD-3-Clause
// Typed values as bytes and back: the one format in which ranks exchange messages and results.
//
// A plain struct travels as it is, with all its members:
//
//     struct Fit { std::string name; std::vector<double> values; std::optional<Rung> rung; };
//
//     const core::Bytes bytes = core::encoded(fit);
//     const Fit same = core::decoded<Fit>(bytes);
//
// Where some members stay behind, or the struct has a base class or constructors, its namespace
// has a function that names the members that travel. It precedes the first use of the struct:
//
//     template <class Wire>
//     void fields(Wire& wire, Fit& fit) { wire(fit.name, fit.values); }
//
// Numbers and enumerations, std::string, vector, array, optional, pair, map, Eigen's vectors and
// matrices of doubles and structs of them travel. Doubles keep every bit. The object of a shared
// pointer to a constant travels as a copy. Anything else, another pointer above all, does not
// compile.
#pragma once

#include "core/aggregate.hpp"

#include <array>
#include <cstddef>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace culm::core {

/// Values travel in their memory layout: all ranks run the same executable on the same
/// architecture.
using Bytes = std::vector<std::byte>;

/// A message is shorter or longer than the values that are read from it.
class WireError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

template <class T, class Wire>
concept TravelsByFields = requires(Wire& wire, T& value) {
    fields(wire, value);
};

template <class T>
concept TravelsByMemory = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <class T, class Wire>
concept TravelsByMembers =
    std::is_class_v<T> && std::is_aggregate_v<T> && !TravelsByFields<T, Wire>;

/// Appends values to a message.
class WireWriter {
  public:
    template <class... Values>
    void operator()(const Values&... values) {
        (put(values), ...);
    }

    template <class T>
    requires TravelsByMemory<T>
    void put(T value) { append(&value, sizeof value); }
    template <class T>
    requires TravelsByFields<T, WireWriter>
    void put(const T& value) {
        fields(*this, const_cast<T&>(value)); // one function for both ways; writing only reads
    }
    template <class T>
    requires TravelsByMembers<T, WireWriter>
    void put(const T& value) { with_members(value, *this); }
    void put(const std::string& text) {
        put(text.size());
        append(text.data(), text.size());
    }
    template <class T>
    void put(const std::vector<T>& values) {
        put(values.size());
        if constexpr (TravelsByMemory<T> && !std::is_same_v<T, bool>)
            append(values.data(), values.size() * sizeof(T));
        else
            for (const auto& value : values)
                put(static_cast<const T&>(value));
    }
    template <int Columns>
    void put(const Eigen::Matrix<double, Eigen::Dynamic, Columns>& matrix) {
        (*this)(matrix.rows(), matrix.cols());
        append(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
    }
    template <class T, std::size_t N>
    void put(const std::array<T, N>& values) {
        for (const T& value : values)
            put(value);
    }
    template <class T>
    void put(const std::optional<T>& value) {
        put(value.has_value());
        if (value)
            put(*value);
    }
    template <class T>
    void put(const std::shared_ptr<const T>& value) {
        put(value != nullptr);
        if (value)
            put(*value);
    }
    template <class First, class Second>
    void put(const std::pair<First, Second>& both) {
        (*this)(both.first, both.second);
    }
    template <class Key, class Value>
    void put(const std::map<Key, Value>& entries) {
        put(entries.size());
        for (const auto& [key, value] : entries)
            (*this)(key, value);
    }

    [[nodiscard]] Bytes take() { return std::move(bytes_); }

  private:
    void append(const void* data, std::size_t size) {
        const auto* first = static_cast<const std::byte*>(data);
        bytes_.insert(bytes_.end(), first, first + size);
    }

    Bytes bytes_;
};

/// Reads what a WireWriter wrote, in the same order. Throws WireError if the message is too short.
class WireReader {
  public:
    explicit WireReader(Bytes bytes) : bytes_(std::move(bytes)) {}

    template <class... Values>
    void operator()(Values&... values) {
        (get(values), ...);
    }
    template <class T>
    [[nodiscard]] T get() {
        T value{};
        get(value);
        return value;
    }

    template <class T>
    requires TravelsByMemory<T>
    void get(T& value) { extract(&value, sizeof value); }
    template <class T>
    requires TravelsByFields<T, WireReader>
    void get(T& value) { fields(*this, value); }
    template <class T>
    requires TravelsByMembers<T, WireReader>
    void get(T& value) { with_members(value, *this); }
    void get(std::string& text) {
        text.resize(get_size(1));
        extract(text.data(), text.size());
    }
    template <class T>
    void get(std::vector<T>& values) {
        if constexpr (TravelsByMemory<T> && !std::is_same_v<T, bool>) {
            values.resize(get_size(sizeof(T)));
            extract(values.data(), values.size() * sizeof(T));
        } else {
            const std::size_t size = get_size(1);
            values.clear();
            for (std::size_t k = 0; k < size; ++k)
                values.push_back(get<T>());
        }
    }
    template <int Columns>
    void get(Eigen::Matrix<double, Eigen::Dynamic, Columns>& matrix) {
        const auto rows = get<Eigen::Index>();
        const auto columns = get<Eigen::Index>();
        const std::size_t most = (bytes_.size() - position_) / sizeof(double);
        if (rows < 0 || columns < 0 || (Columns != Eigen::Dynamic && columns != Columns) ||
            (columns > 0 && rows > static_cast<Eigen::Index>(most) / columns))
            throw_too_short();
        matrix.resize(rows, columns);
        extract(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
    }
    template <class T, std::size_t N>
    void get(std::array<T, N>& values) {
        for (T& value : values)
            get(value);
    }
    template <class T>
    void get(std::optional<T>& value) {
        value.reset();
        if (get<bool>())
            value = get<T>();
    }
    template <class T>
    void get(std::shared_ptr<const T>& value) {
        value = get<bool>() ? std::make_shared<const T>(get<T>()) : nullptr;
    }
    template <class First, class Second>
    void get(std::pair<First, Second>& both) {
        get(both.first);
        get(both.second);
    }
    template <class Key, class Value>
    void get(std::map<Key, Value>& entries) {
        const std::size_t size = get_size(1);
        entries.clear();
        for (std::size_t k = 0; k < size; ++k) {
            auto key = get<Key>();
            entries.emplace(std::move(key), get<Value>());
        }
    }

    [[nodiscard]] bool is_at_end() const { return position_ == bytes_.size(); }

  private:
    /// Reads a number of elements of at least `least_bytes` each. It never exceeds the message's
    /// content, so that a damaged length allocates no memory.
    [[nodiscard]] std::size_t get_size(std::size_t least_bytes) {
        const auto size = get<std::size_t>();
        if (size > (bytes_.size() - position_) / least_bytes)
            throw_too_short();
        return size;
    }
    void extract(void* data, std::size_t size) {
        if (size > bytes_.size() - position_)
            throw_too_short();
        if (size == 0)
            return;
        std::memcpy(data, bytes_.data() + position_, size);
        position_ += size;
    }
    [[noreturn]] static void throw_too_short() {
        throw WireError("a message between ranks ends too early");
    }

    Bytes bytes_;
    std::size_t position_ = 0;
};

template <class T>
[[nodiscard]] Bytes encoded(const T& value) {
    WireWriter out;
    out(value);
    return out.take();
}

/// Throws WireError unless the bytes are one T, whole.
template <class T>
[[nodiscard]] T decoded(Bytes bytes) {
    WireReader in(std::move(bytes));
    T value = in.get<T>();
    if (!in.is_at_end())
        throw WireError("a message between ranks is longer than its content");
    return value;
}

} // namespace culm::core
