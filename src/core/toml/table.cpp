// SPDX-License-Identifier: BSD-3-Clause
#include "core/toml/table.hpp"

#include "core/nearest_name.hpp"
#include "core/toml/value.hpp"
#include "core/units.hpp"
#include "core/user_files.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::core {

namespace {

/// The key without its unit: "length" of "length_mm".
std::string_view quantity_of(std::string_view key) {
    return split_key(key).quantity;
}

/// The hint for a key that names a valid quantity with another unit, or with none.
std::string unit_hint(const TomlEntry& entry, std::span<const std::string> valid) {
    const KeyParts found = split_key(entry.key);
    const auto value = entry.node->value<double>();
    for (const std::string& key : valid) {
        const KeyParts right = split_key(key);
        // The same quantity in another unit: the key was meant.
        if (right.quantity != found.quantity || !right.unit)
            continue;
        if (!found.unit || found.unit->dimension != right.unit->dimension || !value)
            return fmt::format(": write {}, in {}", key, right.unit->name);
        // The value is converted too: with a new key alone the stem would change by powers of ten.
        return fmt::format(": the unit is {} (write {} = {:.12g})", right.unit->name, key,
                           right.unit->from_si(found.unit->to_si(*value)));
    }
    return {};
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
    std::set<const toml::node*> refused;               ///< values in the place of tables

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
    [[nodiscard]] std::string right_place(const TomlEntry& entry) const {
        const std::string& key = entry.key;
        const bool is_table = entry.node->is_table() || entry.node->is_array_of_tables();
        std::vector<std::string> names;
        for (const Place& place : places)
            // A value is not a table of the top level with the same name.
            if (place.has(key) && (is_table || !place.name.empty() || written(key) == key))
                names.push_back(place.name.empty() ? "the top level: write " + written(key)
                                                   : place.written());
        return names.empty() ? ""
                             : fmt::format(": {} belongs into {}", key, fmt::join(names, " or "));
    }

    /// The valid name nearest to an unknown one: the quantity with another unit, or a near name;
    /// first among `valid`, then in the other tables.
    [[nodiscard]] std::string hint(const TomlEntry& entry,
                                   std::span<const std::string> valid_here) const {
        const std::string& key = entry.key;
        if (std::string right = right_place(entry); !right.empty())
            return right;
        if (std::string unit = unit_hint(entry, valid_here); !unit.empty())
            return unit;
        if (const std::string nearest = nearest_name(key, valid_here); !nearest.empty())
            return fmt::format(" (did you mean {}?)", nearest);
        for (const Place& place : places)
            for (const std::string& valid : place.keys)
                if (!place.name.empty() && (quantity_of(valid) == quantity_of(key) ||
                                            edit_distance(valid, key) <= key.size() / 4))
                    return fmt::format(" (did you mean {} in {}?)", valid, place.written());
        return valid_here.empty() ? "" : fmt::format("; allowed: {}", fmt::join(valid_here, ", "));
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

std::string TomlTable::spelling_of(const std::string& key) const {
    const std::string si = si_key(key);
    return !si.empty() && has(si) ? si : key;
}

std::optional<double> TomlTable::quantity(const std::string& key, const Interval& range) const {
    const std::string si = si_key(key);
    // Both spellings become valid keys, whichever is used.
    static_cast<void>(ask(key));
    if (!si.empty())
        static_cast<void>(ask(si, true));
    // Refused even if both are equal, because a later edit may change only one of them.
    if (!si.empty() && has(si) && has(key)) {
        fault(si, fmt::format("is given in addition to {}: one of them is enough", key));
        return std::nullopt;
    }
    // The point is moved in the decimal text, so that the limits print as they are written.
    const std::string spelling = spelling_of(key);
    const Unit unit = split_key(spelling).unit.value_or(dimensionless);
    const auto value =
        number(spelling, {unit.from_si(range.low), unit.from_si(range.high), range.low_open});
    return value ? std::optional(unit.to_si(*value)) : std::nullopt;
}

double TomlTable::required_quantity(const std::string& key, const Interval& range,
                                    std::string_view meaning) const {
    const auto value = quantity(key, range);
    missing(spelling_of(key), meaning);
    return value.value_or(0.0);
}

double TomlTable::last_digit_of(const std::string& key) const {
    const std::string spelling = spelling_of(key);
    if (!has(spelling) || !table_->get(spelling)->is_number())
        return 0.0;
    const double digit = last_digit(written_text(*table_->get(spelling), places_->text));
    return split_key(spelling).unit.value_or(dimensionless).to_si(digit);
}

TomlTable TomlTable::table(const std::string& key) const {
    const toml::node* found = ask(key);
    if (found != nullptr && !found->is_table() && places_->refused.insert(found).second)
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
            if (!here.has(entry.key)) {
                const std::string name =
                    fmt::format("{}{}{}", here.name, here.name.empty() ? "" : ".", entry.key);
                const std::string hint = places_->hint(entry, here.keys);
                if (entry.node->is_table() || entry.node->is_array_of_tables())
                    faults_->add(entry.line, fmt::format("{}: unknown table{}", name, hint));
                else
                    faults_->add(entry.line, name, value_text(*entry.node), "unknown key" + hint);
            }
    }
}

std::string TomlTable::unknown_key_hint(const TomlEntry& entry,
                                        std::span<const std::string> valid) const {
    return "unknown key" + places_->hint(entry, valid);
}

void TomlTable::refuse(std::string_view key, std::string_view reason) const {
    if (has(key))
        fault(key, reason);
    else
        faults_->add(std::max<std::size_t>(line(key), 1),
                     fmt::format("{} is missing: {}", full_key(key), reason));
}

void TomlTable::declare(std::string_view name, std::span<const std::string> keys) const {
    const std::size_t index = name.empty() ? place_ : places_->index_of(full_key(name), false);
    for (const std::string& key : keys)
        if (!places_->places[index].has(key))
            places_->places[index].keys.push_back(key);
}

std::vector<TomlEntry> TomlTable::entries() const {
    return table_ != nullptr ? entries_in_order(*table_) : std::vector<TomlEntry>();
}

const toml::node* TomlTable::node(std::string_view key) const {
    return table_ != nullptr ? table_->get(key) : nullptr;
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
