// SPDX-License-Identifier: BSD-3-Clause
// A number that counts its operations: the work of an algorithm, independent of the compiler. It
// must be included before the headers of the algorithm.
#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Core>

namespace culm::bench {

/// Additions, subtractions, multiplications, divisions and elementary functions so far, one each.
inline thread_local std::int64_t counted_operations = 0;

struct Counted {
    double value = 0.0;

    Counted() = default;
    Counted(double number) : value(number) {} // implicit, as for a double

    Counted& operator+=(const Counted& b) { return *this = *this + b; }
    Counted& operator-=(const Counted& b) { return *this = *this - b; }
    Counted& operator*=(const Counted& b) { return *this = *this * b; }
    Counted& operator/=(const Counted& b) { return *this = *this / b; }

    friend Counted operator+(const Counted& a, const Counted& b) {
        return counted(a.value + b.value);
    }
    friend Counted operator-(const Counted& a, const Counted& b) {
        return counted(a.value - b.value);
    }
    friend Counted operator*(const Counted& a, const Counted& b) {
        return counted(a.value * b.value);
    }
    friend Counted operator/(const Counted& a, const Counted& b) {
        return counted(a.value / b.value);
    }
    friend Counted operator-(const Counted& a) { return {-a.value}; }
    friend Counted sqrt(const Counted& a) { return counted(std::sqrt(a.value)); }
    friend Counted log(const Counted& a) { return counted(std::log(a.value)); }
    friend Counted pow(const Counted& a, const Counted& b) {
        return counted(std::pow(a.value, b.value));
    }
    friend Counted exp(const Counted& a) { return counted(std::exp(a.value)); }
    friend Counted sin(const Counted& a) { return counted(std::sin(a.value)); }
    friend Counted cos(const Counted& a) { return counted(std::cos(a.value)); }
    friend Counted tanh(const Counted& a) { return counted(std::tanh(a.value)); }
    friend Counted abs(const Counted& a) { return {std::abs(a.value)}; }
    friend auto operator<=>(const Counted& a, const Counted& b) = default;

  private:
    static Counted counted(double result) {
        ++counted_operations;
        return {result};
    }
};

} // namespace culm::bench

namespace culm::core {
[[nodiscard]] inline bool all_finite(const bench::Counted& number) {
    return std::isfinite(number.value);
}
} // namespace culm::core

template <>
struct Eigen::NumTraits<culm::bench::Counted> : Eigen::NumTraits<double> {
    using Real = culm::bench::Counted;
    using NonInteger = culm::bench::Counted;
    using Nested = culm::bench::Counted;
    using Literal = double;
    enum { RequireInitialization = 1 };
};
