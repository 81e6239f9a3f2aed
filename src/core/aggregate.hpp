// SPDX-License-Identifier: BSD-3-Clause
// Calls a function with all members of a plain struct, without a list of their names.
//
//     struct Tip { double deflection = 0.0; std::string remark; };
//     core::with_members(tip, [](auto&... members) { (print(members), ...); });
//
// C++20 cannot list the members of a type. A struct accepts as many initial values as it has
// members: trials count them, and structured bindings name that many.
//
// Traps. A base class counts as a member that no binding names, so a struct with a base class is
// refused. So is one with more than 12 members, or with a reference, an array as in C or a bit
// field: the bindings do not match then, and nothing is left out silently.
#pragma once

#include <concepts>
#include <cstddef>
#include <exception>
#include <type_traits>

namespace culm::core {

/// Stands for an initial value of any member. The conversion gives a value and is const: the
/// constructor with which an optional takes any value is then the better match, not an equal one.
/// Never called; it is defined because the compiler also compiles that constructor.
struct AnyMember {
    template <class Member>
    operator Member() const { // NOLINT(google-explicit-constructor)
        std::terminate();
    }
};

/// Stands for an initial value of a base class of T, and of nothing else.
template <class T>
struct AnyBaseOf {
    template <class Base>
    requires(std::is_base_of_v<Base, T> && !std::same_as<Base, T>)
    operator Base() const; // NOLINT(google-explicit-constructor)
};

/// Has the aggregate a base class?
template <class T>
constexpr bool has_base = requires {
    T{AnyBaseOf<T>{}};
};

/// The number of members of an aggregate without base classes.
template <class T, class... Members>
consteval std::size_t member_count() {
    if constexpr (requires { T{Members{}..., AnyMember{}}; })
        return member_count<T, Members..., AnyMember>();
    else
        return sizeof...(Members);
}

/// act(first, second, ...) with all members of the aggregate in their order.
template <class T, class Act>
void with_members(T& value, Act&& act) {
    using Struct = std::remove_const_t<T>;
    static_assert(!has_base<Struct>, "a struct with a base class needs a list of its members");
    constexpr std::size_t count = member_count<Struct>();
    static_assert(count <= 12, "a struct of more than 12 members needs a list of them");
    static_assert(count > 0 || std::is_empty_v<Struct>, "the members cannot be counted");
    // clang-format off
    if constexpr (count == 1) { auto& [a] = value; act(a); }
    if constexpr (count == 2) { auto& [a, b] = value; act(a, b); }
    if constexpr (count == 3) { auto& [a, b, c] = value; act(a, b, c); }
    if constexpr (count == 4) { auto& [a, b, c, d] = value; act(a, b, c, d); }
    if constexpr (count == 5) { auto& [a, b, c, d, e] = value; act(a, b, c, d, e); }
    if constexpr (count == 6) { auto& [a, b, c, d, e, f] = value; act(a, b, c, d, e, f); }
    if constexpr (count == 7) { auto& [a, b, c, d, e, f, g] = value; act(a, b, c, d, e, f, g); }
    if constexpr (count == 8) {
        auto& [a, b, c, d, e, f, g, h] = value;
        act(a, b, c, d, e, f, g, h); }
    if constexpr (count == 9) {
        auto& [a, b, c, d, e, f, g, h, i] = value;
        act(a, b, c, d, e, f, g, h, i); }
    if constexpr (count == 10) {
        auto& [a, b, c, d, e, f, g, h, i, j] = value;
        act(a, b, c, d, e, f, g, h, i, j); }
    if constexpr (count == 11) {
        auto& [a, b, c, d, e, f, g, h, i, j, k] = value;
        act(a, b, c, d, e, f, g, h, i, j, k); }
    if constexpr (count == 12) {
        auto& [a, b, c, d, e, f, g, h, i, j, k, l] = value;
        act(a, b, c, d, e, f, g, h, i, j, k, l); }
    // clang-format on
}

} // namespace culm::core
