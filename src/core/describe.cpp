// SPDX-License-Identifier: BSD-3-Clause
#include "core/describe.hpp"

namespace culm::core {

double scale_of(std::string_view key, double otherwise) {
    const std::optional<Unit> unit = split_key(key).unit;
    // A negative power of ten has no exact double; its reciprocal has.
    return !unit                     ? otherwise
           : unit->power_of_ten <= 0 ? std::pow(10.0, -unit->power_of_ten)
                                     : 1.0 / std::pow(10.0, unit->power_of_ten);
}

nlohmann::json titled_schema(nlohmann::json schema, const std::string& written_by) {
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema";
    schema["description"] = "written by " + written_by;
    return schema;
}

nlohmann::json or_null(nlohmann::json schema) {
    nlohmann::json& type = schema["type"];
    if (!type.is_array())
        type = nlohmann::json::array({type});
    if (std::ranges::find(type, nlohmann::json("null")) == type.end())
        type.push_back("null");
    return schema;
}

nlohmann::json SchemaWriter::Level::schema() const {
    return {{"type", "object"},
            {"properties", properties},
            {"required", required},
            {"additionalProperties", false}};
}

void SchemaWriter::add(std::string_view key, nlohmann::json schema, std::string_view meaning) {
    const std::string name(key);
    if (!meaning.empty())
        schema["description"] = meaning;
    here_.properties[name] = std::move(schema);
    if (here_.conditions == 0)
        here_.required.push_back(name);
}

} // namespace culm::core
