// SPDX-License-Identifier: BSD-3-Clause
#include "core/toml/table.hpp"

#include "core/decimal_text.hpp"
#include "core/nearest_name.hpp"
#include "core/toml/value.hpp"
#include "core/user_files.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::core {

namespace {

/// The key without its unit: "length" of "length_mm".
std::string_view quantity_of(std::string_view key) {
    constexpr std::array<std::string_view, 16> units{
        "_mm", "_m",   "_cm", "_um", "_g",     "_kg",    "_mg", "_mm2",
        "_m2", "_mm4", "_m4", "_s",  "_kg_m3", "_g_cm3", "_ms", "_us"};
    std::size_t longest = 0;
    for (const std::string_view unit : units)
        if (key.ends_with(unit) && key.size() > unit.size())
            longest = std::max(longest, unit.size());
    return key.substr(0, key.size() - longest);
}

std::string must_be(std::string_view allowed, const std::string& otherwise) {
    return "must be " + (allowed.empty() ? otherwise : std::string(allowed));
}

/// convert(node) if the key is present; an empty result is recorded as a fault.
template <class Convert, class Value = std::invoke_result_t<Convert, const toml::node&>>
Value checked(const TomlTable& table, std::string_view key, const toml::node* found,
              std::string_view text, const Convert& convert) {
    Value value = found != nullptr ? convert(*found) : std::nullopt;
    if (found != nullptr && !value)
        table.fault(key, text);
    return value;
}

/// The elements of a list that is not empty, if all of them can be converted.
template <class T, class Convert>
std::optional<std::vector<T>> converted_list(const toml::node& node, const Convert& convert) {
    const toml::array* array = node.as_array();
    if (array == nullptr || array->empty())
        return std::nullopt;
    std::vector<T> values;
    for (const toml::node& element : *array) {
        std::optional<T> value = convert(element);
        if (!value)
            return std::nullopt;
        values.push_back(*std::move(value));
    }
    return values;
}

/// Empty also for a whole number beyond 2⁵³ that no double equals.
std::optional<double> number_in(const toml::node& node, const Interval& range) {
    const auto value = node.value<double>();
    return node.is_number() && value && range.contains(*value) ? value : std::nullopt;
}

bool contains(const std::vector<std::string>& names, std::string_view name) {
    return std::ranges::find(names, name) != names.end();
}

} // namespace

struct TomlTable::Places {
    struct Place {
        std::string name; ///< empty: the top of the file
        bool is_list = false;
        std::vector<std::string> keys;        ///< that are valid, for the lists in messages
        std::vector<std::string> other_units; ///< valid too: the same quantities in SI units

        [[nodiscard]] bool has(std::string_view key) const {
            return contains(keys, key) || contains(other_units, key);
        }
        [[nodiscard]] std::string written() const {
            return is_list ? fmt::format("[[{}]]", name) : fmt::format("[{}]", name);
        }
    };
    std::vector<Place> places;
    std::string text; ///< of the file; a parsed number lacks its trailing zeros
    /// A table that no reader asked for is not among these: it is an unknown key of the table above
    /// it and is reported once, without its content.
    std::map<const toml::table*, std::size_t> reached; ///< with the index of its place

    std::size_t index_of(std::string_view name, bool is_list) {
        const auto found = std::ranges::find(places, name, &Place::name);
        const auto index = static_cast<std::size_t>(found - places.begin());
        if (index == places.size())
            places.push_back({std::string(name), is_list, {}, {}});
        return index;
    }

    /// The header of a table of the top level.
    [[nodiscard]] std::string written(const std::string& name) const {
        const auto found = std::ranges::find(places, name, &Place::name);
        return found == places.end() ? name : found->written();
    }

    /// Tables where a key is valid: "; it belongs into [a] or [[b]]", or nothing.
    [[nodiscard]] std::string right_place(const std::string& key) const {
        std::vector<std::string> names;
        for (const Place& place : places)
            if (place.has(key))
                names.push_back(place.name.empty() ? "the top level: write " + written(key)
                                                   : place.written());
        return names.empty() ? ""
                             : fmt::format(": {} belongs into {}", key, fmt::join(names, " or "));
    }

    /// The valid name nearest to an unknown one.
    [[nodiscard]] std::string hint(const std::string& key, const Place& here) const {
        if (std::string right = right_place(key); !right.empty())
            return right;
        // The quantity with another unit, or a near name; first in this table, then in the others.
        for (const std::string& valid : here.keys)
            if (quantity_of(valid) == quantity_of(key))
                return fmt::format(" (did you mean {}?)", valid);
        if (const std::string nearest = nearest_name(key, here.keys); !nearest.empty())
            return fmt::format(" (did you mean {}?)", nearest);
        for (const Place& place : places)
            for (const std::string& valid : place.keys)
                if (!place.name.empty() && (quantity_of(valid) == quantity_of(key) ||
                                            edit_distance(valid, key) <= key.size() / 4))
                    return fmt::format(" (did you mean {} in {}?)", valid, place.written());
        return here.keys.empty() ? "" : fmt::format("; allowed: {}", fmt::join(here.keys, ", "));
    }
};

TomlTable::TomlTable(const toml::table* table, std::string_view name, FileFaults& faults)
    : table_(table), place_(0), places_(std::make_shared<Places>()), faults_(&faults) {
    place_ = places_->index_of(name, false);
    if (table != nullptr)
        places_->reached.emplace(table, place_);
}

TomlTable::TomlTable(const toml::table* table, std::string_view name, bool is_list,
                     const TomlTable& parent)
    : table_(table), place_(parent.places_->index_of(name, is_list)), places_(parent.places_),
      faults_(parent.faults_) {
    if (table != nullptr)
        places_->reached.emplace(table, place_);
}

bool TomlTable::has(std::string_view key) const {
    return table_ != nullptr && table_->contains(key);
}

bool TomlTable::is_text(std::string_view key) const {
    return has(key) && table_->get(key)->is_string();
}

std::size_t TomlTable::line(std::string_view key) const {
    if (table_ == nullptr)
        return 0;
    const toml::node* found = table_->get(key);
    return found != nullptr ? line_of(*found) : line_of(*table_);
}

std::vector<std::string> TomlTable::keys() const {
    std::vector<std::string> keys;
    if (table_ != nullptr)
        for (TomlEntry& entry : entries_in_order(*table_))
            keys.push_back(std::move(entry.key));
    return keys;
}

std::optional<std::string> TomlTable::text(const std::string& key, std::string_view allowed) const {
    return checked(*this, key, ask(key), must_be(allowed, ""), [](const toml::node& node) {
        auto value = node.value_exact<std::string>();
        return value && !value->empty() ? value : std::nullopt;
    });
}

std::optional<std::size_t> TomlTable::word(const std::string& key,
                                           std::span<const std::string> valid,
                                           std::string_view allowed) const {
    const toml::node* found = ask(key);
    if (found == nullptr)
        return std::nullopt;
    const std::string value = found->value_exact<std::string>().value_or("");
    if (const auto match = std::ranges::find(valid, value); match != valid.end())
        return static_cast<std::size_t>(match - valid.begin());
    const std::string nearest = nearest_name(value, valid);
    fault(key, must_be(allowed, one_of(valid)) +
                   (nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest)));
    return std::nullopt;
}

std::optional<double> TomlTable::number(const std::string& key, const Interval& range,
                                        std::string_view allowed) const {
    const toml::node* found = ask(key);
    if (found == nullptr)
        return std::nullopt;
    if (const auto value = number_in(*found, range))
        return value;
    const std::string text = found->value_exact<std::string>().value_or("");
    if (text.find("±") != std::string::npos)
        fault(key, "must be a number without quotes; a bare ± does not say what it means: give "
                   "the standard uncertainty in a separate key");
    else if (found->is_string() && allowed.empty())
        fault(key, "must be a number without quotes, with a decimal point");
    else
        fault(key, must_be(allowed, "a number in " + range.text()));
    return std::nullopt;
}

std::optional<std::int64_t> TomlTable::whole_number(const std::string& key, const Interval& range,
                                                    std::string_view allowed) const {
    return checked(*this, key, ask(key), must_be(allowed, "a whole number in " + range.text()),
                   [&range](const toml::node& node) {
                       const auto value = node.value_exact<std::int64_t>();
                       return value && range.contains(static_cast<double>(*value)) ? value
                                                                                   : std::nullopt;
                   });
}

std::optional<bool> TomlTable::flag(const std::string& key) const {
    return checked(*this, key, ask(key), "must be true or false, without quotes",
                   [](const toml::node& node) { return node.value_exact<bool>(); });
}

std::vector<double> TomlTable::numbers(const std::string& key, const Interval& range,
                                       std::string_view allowed) const {
    const auto number = [&range](const toml::node& element) { return number_in(element, range); };
    return checked(*this, key, ask(key), must_be(allowed, "a list of numbers in " + range.text()),
                   [&](const toml::node& node) { return converted_list<double>(node, number); })
        .value_or(std::vector<double>());
}

std::vector<std::string> TomlTable::texts(const std::string& key) const {
    const auto text = [](const toml::node& element) { return element.value_exact<std::string>(); };
    return checked(*this, key, ask(key), "must be a list of texts in quotes",
                   [&](const toml::node& node) { return converted_list<std::string>(node, text); })
        .value_or(std::vector<std::string>());
}

std::string TomlTable::key_of(const std::string& name, const KeyUnit& unit) const {
    const std::string si = fmt::format("{}_{}", name, unit.si);
    return !unit.si.empty() && has(si) ? si : fmt::format("{}_{}", name, unit.small);
}

std::optional<double> TomlTable::quantity(const std::string& name, const KeyUnit& unit,
                                          const Interval& range) const {
    const std::string small = fmt::format("{}_{}", name, unit.small);
    if (unit.si.empty())
        return number(small, range);
    const std::string si = fmt::format("{}_{}", name, unit.si);
    const bool is_small = has(small) || !has(si);
    // Both spellings become valid keys, whichever is used.
    static_cast<void>(ask(small));
    static_cast<void>(ask(si, true));
    // Refused even if both are equal, because a later edit may change only one of them.
    if (has(si) && has(small)) {
        fault(si, fmt::format("is given in addition to {}: one of them is enough", small));
        return std::nullopt;
    }
    // The point is moved in the decimal text, so that the limits print as they are written.
    const int power = is_small ? unit.power_of_ten : 0;
    const auto value =
        number(is_small ? small : si, {with_point_moved(range.low, -power),
                                       with_point_moved(range.high, -power), range.low_open});
    return value ? std::optional(with_point_moved(*value, power)) : std::nullopt;
}

double TomlTable::required_quantity(const std::string& name, const KeyUnit& unit,
                                    const Interval& range, std::string_view meaning) const {
    const auto value = quantity(name, unit, range);
    missing(key_of(name, unit), meaning);
    return value.value_or(0.0);
}

double TomlTable::last_digit_of(const std::string& name, const KeyUnit& unit) const {
    const std::string key = key_of(name, unit);
    if (!has(key) || !table_->get(key)->is_number())
        return 0.0;
    const bool is_small = unit.si.empty() || key != fmt::format("{}_{}", name, unit.si);
    return with_point_moved(last_digit(written_text(*table_->get(key), places_->text)),
                            is_small ? unit.power_of_ten : 0);
}

std::optional<double> TomlTable::length(const std::string& name, const Interval& range) const {
    return quantity(name, length_unit, range);
}

double TomlTable::required_length(const std::string& name, const Interval& range,
                                  std::string_view meaning) const {
    return required_quantity(name, length_unit, range, meaning);
}

TomlTable TomlTable::table(const std::string& key) const {
    const toml::node* found = ask(key);
    if (found != nullptr && !found->is_table())
        fault(key, fmt::format("must be a table: write [{}]", full_key(key)));
    return {found != nullptr ? found->as_table() : nullptr, full_key(key), false, *this};
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) const {
    const toml::node* found = ask(key);
    std::vector<TomlTable> tables;
    if (found == nullptr)
        return tables;
    const toml::array* array = found->as_array();
    if (array == nullptr || !array->is_array_of_tables()) {
        fault(key, fmt::format("must be a list of tables: write [[{}]]", full_key(key)));
        return tables;
    }
    for (const toml::node& element : *array)
        tables.push_back({element.as_table(), full_key(key), true, *this});
    return tables;
}

TomlTable TomlTable::absent(const std::string& key) const {
    return {nullptr, full_key(key), true, *this};
}

void TomlTable::missing(const std::string& key, std::string_view allowed) const {
    if (table_ != nullptr && !has(key))
        faults_->add(line(key), fmt::format("{} is missing: {}", full_key(key), allowed));
}

void TomlTable::fault(std::string_view key, std::string_view text) const {
    const toml::node* found = table_ != nullptr ? table_->get(key) : nullptr;
    if (found != nullptr)
        faults_->add(line(key), full_key(key), value_text(*found), text);
    else
        faults_->add(line(key), fmt::format("{}: {}", full_key(key), text));
}

void TomlTable::refuse_unknown_keys() const {
    for (const auto& [table, place] : places_->reached) {
        const Places::Place& here = places_->places[place];
        for (const TomlEntry& entry : entries_in_order(*table))
            if (!here.has(entry.key))
                faults_->add(entry.line, fmt::format("{}{}{}: unknown {}{}", here.name,
                                                     here.name.empty() ? "" : ".", entry.key,
                                                     entry.node->is_table() ? "table" : "key",
                                                     places_->hint(entry.key, here)));
    }
}

const toml::node* TomlTable::ask(const std::string& key, bool is_other_unit) const {
    // Reading a key declares it valid, so the accepted keys are exactly those that are read.
    Places::Place& place = places_->places[place_];
    if (!place.has(key))
        (is_other_unit ? place.other_units : place.keys).push_back(key);
    return table_ != nullptr ? table_->get(key) : nullptr;
}

void TomlTable::leave(const std::string& key) const {
    static_cast<void>(ask(key));
}

std::string TomlTable::full_key(std::string_view key) const {
    const std::string& name = places_->places[place_].name;
    return name.empty() ? std::string(key) : fmt::format("{}.{}", name, key);
}

TomlDocument::TomlDocument(const std::filesystem::path& file)
    : TomlDocument(file_text(file), file.string()) {}

TomlDocument::TomlDocument(std::string_view text, const std::string& file)
    : parsed_(std::make_unique<const toml::table>(parse_toml_text(text, file))), faults_(file),
      root_(parsed_.get(), "", faults_) {
    root_.places_->text = text;
}

TomlDocument::~TomlDocument() = default;

void TomlDocument::finish() {
    root_.refuse_unknown_keys();
    faults_.throw_if_any();
}

} // namespace culm::core
