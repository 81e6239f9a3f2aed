// SPDX-License-Identifier: BSD-3-Clause
// JSON and its schema from one description of a result. A result names each member once:
//
//     template <class To>
//     void describe(To& to, const Tip& tip) {
//         to("deflection_mm", tip.deflection, "at the release");
//         to("adequate", [&] { return is_adequate(tip); });
//         to.when(tip.has_offset, [&] { to("offset_mm", tip.offset); });
//         to.object("fit", [&] { to("rmse_mm", tip.rmse); });
//         to.list("modes", tip.modes, [&](const Mode& mode) { to("b2_hz", mode.frequency); });
//     }
//
// Numbers are in SI and are written in the unit with which the key ends, or in that of the member
// that contains the result. A function computes a value that is not a member; the schema takes only
// its type, from a result without content. Members under `when` may be absent; `maybe` writes an
// object or null, and so does an optional. Both take an optional and pass its value to the
// function. A type with the members `lower` and `upper` is written as [lower, upper]. Results are
// sent between ranks as plain structs (core/wire.hpp).
#pragma once

#include "core/units.hpp"

#include <cmath>
#include <concepts>
#include <optional>
#include <ranges>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace culm::core {

class JsonWriter;

template <class T>
concept Described = requires(JsonWriter& to, const T& value) {
    describe(to, value);
};

template <class T>
concept TextLike = std::convertible_to<T, std::string_view>;

/// Bounds of an interval.
template <class T>
concept Bounded = requires(const T& value) {
    value.lower;
    value.upper;
};

/// Refers to a result, or to one without content, of which a schema is made.
template <class T>
class Viewed {
  public:
    Viewed() : object_(&without_content()) {}
    Viewed(const T& object) : object_(&object) {} // as a reference

    [[nodiscard]] const T& operator*() const { return *object_; }
    [[nodiscard]] const T* operator->() const { return object_; }

  private:
    static const T& without_content() {
        static const T object{};
        return object;
    }
    const T* object_;
};

/// The factor from SI to the unit with which a key ends; `otherwise` for keys without a unit.
[[nodiscard]] double scale_of(std::string_view key, double otherwise);

/// A number, or null for NaN and infinities, which JSON does not have.
[[nodiscard]] inline nlohmann::json number(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

/// The type that a function returns, or the type itself.
template <class T>
struct ValueOf {
    using Type = T;
};
template <std::invocable T>
struct ValueOf<T> {
    using Type = std::remove_cvref_t<std::invoke_result_t<const T&>>;
};
/// The elements of a list, or of the list that a function returns.
template <class List>
using ElementOf = std::remove_cvref_t<std::ranges::range_value_t<typename ValueOf<List>::Type>>;

/// The JSON of a described result; `scale` multiplies numbers whose keys have no unit.
template <Described T>
[[nodiscard]] nlohmann::json json_of(const T& value, double scale = 1.0);

/// The JSON of a value whose numbers are multiplied by `scale`.
template <class T>
[[nodiscard]] nlohmann::json json_value(const T& value, double scale) {
    using nlohmann::json;
    if constexpr (std::floating_point<T>)
        return number(scale == 1.0 ? value : scale * value);
    else if constexpr (std::integral<T>)
        return value;
    else if constexpr (TextLike<T>)
        return std::string(std::string_view(value));
    else if constexpr (Described<T>)
        return json_of(value, scale);
    else if constexpr (Bounded<T>)
        return json::array({json_value(value.lower, scale), json_value(value.upper, scale)});
    else if constexpr (std::invocable<const T&>)
        return json_value<typename ValueOf<T>::Type>(value(), scale);
    else if constexpr (requires { value.has_value(); })
        return value ? json_value(*value, scale) : json(nullptr);
    else if constexpr (requires { typename T::mapped_type; }) {
        json out = json::object();
        for (const auto& [key, member] : value)
            out[key] = json_value(member, scale);
        return out;
    } else {
        json out = json::array();
        for (const auto& item : value)
            out.push_back(json_value<ElementOf<T>>(item, scale));
        return out;
    }
}

/// Writes the members of one result.
class JsonWriter {
  public:
    explicit JsonWriter(double scale) : scale_(scale) {}
    JsonWriter(const JsonWriter&) = delete;
    JsonWriter& operator=(const JsonWriter&) = delete;

    template <class T>
    void operator()(std::string_view key, const T& value, std::string_view /*meaning*/ = {}) {
        member(key) = json_value(value, scale_of(key, scale_));
    }
    /// A value that is in the unit of its key already.
    template <class T>
    void as_it_is(std::string_view key, const T& value) {
        member(key) = json_value(value, 1.0);
    }
    /// A member that is the same in every result.
    template <class T>
    void constant(std::string_view key, const T& value) {
        member(key) = json_value(value, 1.0);
    }
    template <std::invocable Members>
    void object(std::string_view key, const Members& members, std::string_view /*meaning*/ = {}) {
        member(key) = enclosed(members);
    }
    template <std::invocable Members>
    void maybe(std::string_view key, bool exists, const Members& members,
               std::string_view /*meaning*/ = {}) {
        member(key) = exists ? enclosed(members) : nlohmann::json(nullptr);
    }
    template <class List, class Members>
    void list(std::string_view key, const List& items, const Members& members,
              std::string_view /*meaning*/ = {}) {
        nlohmann::json out = nlohmann::json::array();
        const auto add = [&](const auto& all) {
            for (const auto& item : all)
                out.push_back(enclosed([&] { members(item); }));
        };
        if constexpr (std::invocable<const List&>)
            add(items());
        else
            add(items);
        member(key) = std::move(out);
    }
    /// Results of type T as JSON text each.
    template <class T>
    void encoded(std::string_view key, const std::vector<std::string>& texts) {
        nlohmann::json& all = member(key) = nlohmann::json::array();
        for (const std::string& text : texts)
            all.push_back(nlohmann::json::parse(text));
    }
    template <class T, class Members>
    void maybe(std::string_view key, const std::optional<T>& value, const Members& members,
               std::string_view /*meaning*/ = {}) {
        maybe(key, value.has_value(), [&] { members(*value); });
    }
    template <std::invocable Members>
    void when(bool exists, const Members& members) {
        if (exists)
            members();
    }
    template <class T, class Members>
    void when(const std::optional<T>& value, const Members& members) {
        if (value)
            members(*value);
    }
    [[nodiscard]] nlohmann::json take() { return std::move(out_); }

  private:
    nlohmann::json& member(std::string_view key) { return (*here_)[std::string(key)]; }
    nlohmann::json enclosed(const std::invocable auto& members) {
        nlohmann::json inner = nlohmann::json::object();
        nlohmann::json* const outer = std::exchange(here_, &inner);
        members();
        here_ = outer;
        return inner;
    }

    double scale_; ///< of the member that contains this result
    nlohmann::json out_ = nlohmann::json::object();
    nlohmann::json* here_ = &out_; ///< the object whose members are written now
};

template <Described T>
nlohmann::json json_of(const T& value, double scale) {
    JsonWriter writer(scale);
    describe(writer, value);
    return writer.take();
}

/// A schema with its dialect, a title and the programs that write the document.
[[nodiscard]] nlohmann::json titled_schema(nlohmann::json schema, const std::string& written_by);

/// The schema of a value of the same type, or null.
[[nodiscard]] nlohmann::json or_null(nlohmann::json schema);

/// The schema (JSON Schema, draft 2020-12) of a described result.
template <class T>
[[nodiscard]] nlohmann::json schema_of();

/// The schema of a value.
template <class T>
[[nodiscard]] nlohmann::json schema_value() {
    using nlohmann::json;
    if constexpr (std::floating_point<T>)
        return {{"type", {"number", "null"}}};
    else if constexpr (std::same_as<T, bool>)
        return {{"type", "boolean"}};
    else if constexpr (std::integral<T>)
        return {{"type", "integer"}};
    else if constexpr (TextLike<T>)
        return {{"type", "string"}};
    else if constexpr (Described<T>)
        return schema_of<T>();
    else if constexpr (Bounded<T>)
        return {{"type", "array"},
                {"items", {{"type", {"number", "null"}}}},
                {"minItems", 2},
                {"maxItems", 2}};
    else if constexpr (std::invocable<const T&>)
        return schema_value<typename ValueOf<T>::Type>();
    else if constexpr (requires(const T& value) { value.has_value(); })
        return or_null(schema_value<std::remove_cvref_t<decltype(*std::declval<const T&>())>>());
    else if constexpr (requires { typename T::mapped_type; })
        return {{"type", "object"},
                {"additionalProperties", schema_value<typename T::mapped_type>()}};
    else
        return {{"type", "array"}, {"items", schema_value<ElementOf<T>>()}};
}

/// Writes the schema of one result.
class SchemaWriter {
  public:
    template <class T>
    void operator()(std::string_view key, const T& /*value*/, std::string_view meaning = {}) {
        add(key, schema_value<T>(), meaning);
    }
    template <class T>
    void as_it_is(std::string_view key, const T& /*value*/) {
        add(key, schema_value<T>(), {});
    }
    template <class T>
    void constant(std::string_view key, const T& value) {
        add(key, {{"const", json_value(value, 1.0)}}, {});
    }
    template <std::invocable Members>
    void object(std::string_view key, const Members& members, std::string_view meaning = {}) {
        add(key, enclosed(members), meaning);
    }
    template <std::invocable Members>
    void maybe(std::string_view key, bool /*exists*/, const Members& members,
               std::string_view meaning = {}) {
        add(key, or_null(enclosed(members)), meaning);
    }
    template <class List, class Members>
    void list(std::string_view key, const List& /*items*/, const Members& members,
              std::string_view meaning = {}) {
        const ElementOf<List> without_content{};
        add(key, {{"type", "array"}, {"items", enclosed([&] { members(without_content); })}},
            meaning);
    }
    template <class T>
    void encoded(std::string_view key, const std::vector<std::string>& /*texts*/) {
        add(key, schema_value<std::vector<T>>(), {});
    }
    template <class T, class Members>
    void maybe(std::string_view key, const std::optional<T>& /*value*/, const Members& members,
               std::string_view meaning = {}) {
        static const T without_content{};
        maybe(
            key, false, [&] { members(without_content); }, meaning);
    }
    template <std::invocable Members>
    void when(bool /*exists*/, const Members& members) {
        ++here_.conditions;
        members();
        --here_.conditions;
    }
    template <class T, class Members>
    void when(const std::optional<T>& /*value*/, const Members& members) {
        static const T without_content{};
        when(false, [&] { members(without_content); });
    }
    [[nodiscard]] nlohmann::json take() { return here_.schema(); }

  private:
    /// The object whose members are written now.
    struct Level {
        nlohmann::json properties = nlohmann::json::object();
        nlohmann::json required = nlohmann::json::array();
        int conditions = 0; ///< that enclose the member

        [[nodiscard]] nlohmann::json schema() const;
    };
    void add(std::string_view key, nlohmann::json schema, std::string_view meaning);
    nlohmann::json enclosed(const std::invocable auto& members) {
        Level outer = std::exchange(here_, Level{});
        members();
        return std::exchange(here_, std::move(outer)).schema();
    }

    Level here_;
};

template <class T>
nlohmann::json schema_of() {
    SchemaWriter writer;
    describe(writer, T{});
    return writer.take();
}

} // namespace culm::core
