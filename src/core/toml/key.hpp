// SPDX-License-Identifier: BSD-3-Clause
// The keys of a TOML file as rows of a table. One row declares a key: its name, the member of the
// options that it sets, what is allowed, and its meaning. The reader, the hints for unknown keys,
// the defaults, the reference in the documentation and the identity of the options follow from it:
//
//     KeyTable<Options> keys("timestep");
//     keys.key("record_cycles", &Options::record_cycles, {1.0, 1000.0}, "length of the histories")
//         .only_if("timestep.fractions", has_fractions, "only with timestep.fractions");
//
// The default is the initialiser of the member. The unit is that with which the key ends; members
// are in SI.
#pragma once

#include "core/interval.hpp"
#include "core/toml/table.hpp"
#include "core/units.hpp"

#include <algorithm>
#include <array>
#include <concepts>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace culm::core {

enum class ValueKind { Text, Word, Number, WholeNumber, NumberList, WordList, Tables };

/// A key as text.
struct KeyDescription {
    std::string table = {}; ///< for example "study", or "factors.<parameter>"
    std::string name = {};
    ValueKind kind = ValueKind::Number;
    std::string unit = {};               ///< as it is printed; empty for none
    std::string default_text = {};       ///< empty: see `meaning`
    Interval range = {};                 ///< of numbers
    std::vector<std::string> words = {}; ///< of Word
    std::string meaning = {};

    /// "integrator.method".
    [[nodiscard]] std::string full_name() const { return table + "." + name; }
    /// The allowed values, for messages: "a number in (0, 1000] mm".
    [[nodiscard]] std::string allowed() const;
};

/// A word of a key and the value that the member gets.
template <class Value>
struct Choice {
    std::string_view word;
    Value value;
};
template <class Value, std::size_t Count>
using Choices = std::array<Choice<Value>, Count>;

/// The word for a value; empty if there is none.
template <class Value, std::size_t Count>
[[nodiscard]] constexpr std::string_view word_of(const Choices<Value, Count>& choices,
                                                 const Value& value) {
    const auto found = std::ranges::find(choices, value, &Choice<Value>::value);
    return found == choices.end() ? std::string_view() : found->word;
}

/// The member of a member …, for example of StudyConfig::base: path(&StudyConfig::base,
/// &run::CaseSpec::duration).
template <class... Members>
[[nodiscard]] constexpr auto path(Members... members) {
    return [=](auto& object) -> auto& {
        return (object.*....*members);
    };
}

template <class Options>
struct Key : KeyDescription {
    using Predicate = std::function<bool(const Options&)>;
    /// A condition on other keys. It is not examined if the value of the key that decides is
    /// wrong: the message would follow from a default that the user did not want.
    struct Condition {
        std::string decided_by; ///< full name of a key
        Predicate holds;
        std::string reason; ///< for the message
    };

    /// Sets the member if the table has the key. False if its value is wrong, which is recorded.
    std::function<bool(const TomlTable&, Options&)> read;
    /// The value of the member in the key's unit; empty if it has none.
    std::function<std::string(const Options&)> text;
    std::vector<Condition> used;
    std::vector<Condition> needed;
    bool influences_results = true;

    Key& only_if(std::string decided_by, Predicate holds, std::string reason) {
        used.push_back({std::move(decided_by), std::move(holds), std::move(reason)});
        return *this;
    }
    Key& needed_if(std::string decided_by, Predicate holds, std::string reason) {
        needed.push_back({std::move(decided_by), std::move(holds), std::move(reason)});
        return *this;
    }
    /// States the default as text, where it is not the initialiser of the member.
    Key& otherwise(const std::string& words_for_default) {
        default_text = words_for_default;
        return *this;
    }
    /// Another form of the value for the identity.
    Key& shown_as(std::function<std::string(const Options&)> form) {
        text = std::move(form);
        return *this;
    }
    /// The key does not change results, so the identity does not contain it.
    Key& without_influence() {
        influences_results = false;
        return *this;
    }
    [[nodiscard]] bool is_used(const Options& options) const {
        return std::ranges::all_of(used, [&](const auto& each) { return each.holds(options); });
    }
};

/// The keys of one TOML table. `Options` is what the whole file describes.
template <class Options>
class KeyTable {
  public:
    explicit KeyTable(std::string name) : name_(std::move(name)) {}

    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] const std::vector<Key<Options>>& keys() const { return keys_; }

    // `access` gives the member of the options: a pointer to it, or path().

    /// A number, a whole number or a list of numbers; `range` is in the unit of the key.
    template <class Access>
    Key<Options>& key(const std::string& name, Access access, const Interval& range,
                      const std::string& meaning) {
        return add(name, access, range, meaning);
    }
    /// A word of several.
    template <class Access, class Value, std::size_t Count>
    Key<Options>& key(const std::string& name, Access access, const Choices<Value, Count>& choices,
                      const std::string& meaning);
    /// A text.
    template <class Access>
    Key<Options>& key(const std::string& name, Access access, const std::string& meaning) {
        return add(name, access, {}, meaning);
    }
    /// A key whose value is read by its own function.
    Key<Options>& key(KeyDescription description) {
        description.table = name_;
        Key<Options>& row = keys_.emplace_back();
        static_cast<KeyDescription&>(row) = std::move(description);
        row.read = [](const TomlTable&, Options&) { return true; };
        row.text = [](const Options&) { return std::string(); };
        return row;
    }

    /// Sets the members of the keys that `table` has; `wrong` gets the full names of wrong ones.
    void read(const TomlTable& table, Options& options, std::set<std::string>& wrong) const {
        for (const Key<Options>& row : keys_)
            if (table.has(row.name) && !row.read(table, options))
                wrong.insert(row.full_name());
    }
    /// After all tables were read: records keys that are not used or are missing.
    void check(const TomlTable& table, const Options& options,
               const std::set<std::string>& wrong) const {
        for (const Key<Options>& row : keys_) {
            const bool is_given = table.has(row.name);
            for (const auto& condition : is_given ? row.used : row.needed)
                if (!wrong.contains(condition.decided_by) && condition.holds(options) != is_given) {
                    table.refuse(row.name, condition.reason);
                    break;
                }
        }
    }
    /// "table.key" and its value, of all keys that influence results and are used.
    void add_identity(const Options& options,
                      std::map<std::string, std::string, std::less<>>& lines) const {
        for (const Key<Options>& row : keys_) {
            std::string value = row.text(options);
            if (row.influences_results && !value.empty() && row.is_used(options))
                lines[row.full_name()] = std::move(value);
        }
    }

  private:
    template <class Access>
    Key<Options>& add(const std::string& name, Access access, const Interval& range,
                      const std::string& meaning);

    std::string name_;
    std::vector<Key<Options>> keys_;
};

/// The member is a T, or an optional T.
template <class T>
struct MemberValue {
    using Type = T;
};
template <class T>
struct MemberValue<std::optional<T>> {
    using Type = T;
};

/// A member's value in the unit of its key; empty for a list without elements or an optional
/// without a value.
template <class T>
[[nodiscard]] std::string member_text(const T& value, const Unit& unit) {
    if constexpr (std::same_as<T, std::string>)
        return value;
    else if constexpr (std::same_as<T, std::vector<double>>) {
        std::string text;
        for (const double each : value)
            text += fmt::format("{}{}", text.empty() ? "[" : ", ", unit.from_si(each));
        return text.empty() ? text : text + "]";
    } else if constexpr (!std::same_as<T, typename MemberValue<T>::Type>)
        return value ? member_text(*value, unit) : std::string();
    else if constexpr (std::floating_point<T>)
        return fmt::format("{}", unit.from_si(value));
    else
        return fmt::format("{}", value);
}

/// The value of a key in SI; nothing if it is wrong, which is recorded.
template <class Value>
[[nodiscard]] std::optional<Value> read_value(const TomlTable& table, const KeyDescription& key) {
    const std::string allowed = key.allowed();
    if constexpr (std::same_as<Value, std::string>)
        return table.text(key.name, allowed);
    else if constexpr (std::integral<Value>) {
        const auto whole = table.whole_number(key.name, key.range, allowed);
        return whole ? std::optional(static_cast<Value>(*whole)) : std::nullopt;
    } else {
        const Unit unit = split_key(key.name).unit.value_or(dimensionless);
        if constexpr (std::same_as<Value, double>) {
            const auto number = table.number(key.name, key.range, allowed);
            return number ? std::optional(unit.to_si(*number)) : std::nullopt;
        } else {
            Value numbers = table.numbers(key.name, key.range, allowed);
            for (double& number : numbers)
                number = unit.to_si(number);
            return numbers.empty() ? std::nullopt : std::optional(std::move(numbers));
        }
    }
}

template <class Options>
template <class Access>
Key<Options>& KeyTable<Options>::add(const std::string& name, Access access, const Interval& range,
                                     const std::string& meaning) {
    using Member = std::remove_cvref_t<std::invoke_result_t<Access, Options&>>;
    using Value = typename MemberValue<Member>::Type;
    const Unit unit = split_key(name).unit.value_or(dimensionless);
    Key<Options>& row =
        key({.name = name,
             .kind = std::same_as<Value, std::string>           ? ValueKind::Text
                     : std::same_as<Value, std::vector<double>> ? ValueKind::NumberList
                     : std::integral<Value>                     ? ValueKind::WholeNumber
                                                                : ValueKind::Number,
             .unit = std::string(unit.name),
             .range = range,
             .meaning = meaning});
    row.text = [access, unit](const Options& options) {
        return member_text(std::invoke(access, options), unit);
    };
    row.default_text = row.text(Options{});
    row.read = [access, key = static_cast<KeyDescription>(row)](const TomlTable& table,
                                                                Options& options) {
        std::optional<Value> value = read_value<Value>(table, key);
        const bool is_right = value.has_value();
        if (is_right)
            std::invoke(access, options) = *std::move(value);
        return is_right;
    };
    return row;
}

template <class Options>
template <class Access, class Value, std::size_t Count>
Key<Options>& KeyTable<Options>::key(const std::string& name, Access access,
                                     const Choices<Value, Count>& choices,
                                     const std::string& meaning) {
    Key<Options>& row = key({.name = name, .kind = ValueKind::Word, .meaning = meaning});
    for (const Choice<Value>& choice : choices)
        row.words.emplace_back(choice.word);
    row.text = [access, choices](const Options& options) {
        return std::string(word_of(choices, std::invoke(access, options)));
    };
    row.default_text = fmt::format("\"{}\"", row.text(Options{}));
    row.read = [access, choices, name, words = row.words,
                allowed = row.allowed()](const TomlTable& table, Options& options) {
        const auto index = table.word(name, words, allowed);
        if (index)
            std::invoke(access, options) = choices[*index].value;
        return index.has_value();
    };
    return row;
}

/// Markdown tables of the keys, one for each TOML table.
[[nodiscard]] std::string markdown_tables(const std::vector<KeyDescription>& keys);

} // namespace culm::core
