// SPDX-License-Identifier: BSD-3-Clause
// Small vectors over any scalar type (double, SIMD lanes, dual numbers).
// Eigen is not used here: its normalisation and comparisons do not compile for SIMD scalars.
#pragma once

#include <array>
#include <cstddef>

namespace culm::core {

/// A vector of Dim components of the scalar type T.
template <int Dim, class T>
struct Vec {
    std::array<T, static_cast<std::size_t>(Dim)> component;

    [[nodiscard]] constexpr T& operator[](int i) { return component[static_cast<std::size_t>(i)]; }
    [[nodiscard]] constexpr const T& operator[](int i) const {
        return component[static_cast<std::size_t>(i)];
    }

    [[nodiscard]] static constexpr Vec zero() {
        Vec v;
        v.component.fill(T(0.0));
        return v;
    }

    constexpr Vec& operator+=(const Vec& b) {
        for (int i = 0; i < Dim; ++i)
            (*this)[i] = (*this)[i] + b[i];
        return *this;
    }
    constexpr Vec& operator-=(const Vec& b) {
        for (int i = 0; i < Dim; ++i)
            (*this)[i] = (*this)[i] - b[i];
        return *this;
    }
};

template <int Dim, class T>
[[nodiscard]] constexpr Vec<Dim, T> operator+(Vec<Dim, T> a, const Vec<Dim, T>& b) {
    return a += b;
}

template <int Dim, class T>
[[nodiscard]] constexpr Vec<Dim, T> operator-(Vec<Dim, T> a, const Vec<Dim, T>& b) {
    return a -= b;
}

template <int Dim, class T>
[[nodiscard]] constexpr Vec<Dim, T> operator-(Vec<Dim, T> a) {
    for (int i = 0; i < Dim; ++i)
        a[i] = -a[i];
    return a;
}

template <int Dim, class T>
[[nodiscard]] constexpr Vec<Dim, T> operator*(const T& s, Vec<Dim, T> a) {
    for (int i = 0; i < Dim; ++i)
        a[i] = s * a[i];
    return a;
}

template <int Dim, class T>
[[nodiscard]] constexpr T dot(const Vec<Dim, T>& a, const Vec<Dim, T>& b) {
    T sum = a[0] * b[0];
    for (int i = 1; i < Dim; ++i)
        sum = sum + a[i] * b[i];
    return sum;
}

template <class T>
[[nodiscard]] constexpr Vec<3, T> cross(const Vec<3, T>& a, const Vec<3, T>& b) {
    return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

/// Component along z of the cross product of two vectors in the plane.
template <class T>
[[nodiscard]] constexpr T cross(const Vec<2, T>& a, const Vec<2, T>& b) {
    return a[0] * b[1] - a[1] * b[0];
}

} // namespace culm::core
