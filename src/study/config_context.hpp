// SPDX-License-Identifier: BSD-3-Clause
// What the parts of the config reader share while one file is read.
#pragma once

#include "study/config.hpp"
#include "study/config_errors.hpp"

#include <functional>
#include <map>
#include <string>
#include <string_view>

#include <toml++/toml.h>

namespace culm::study {

/// Where a parameter was given.
struct GivenPlace {
    std::string section; ///< "stem", "release", "factors" or "design.point"
    std::size_t line = 0;
};

struct ConfigContext {
    const toml::table& root;
    StudyConfig& config;
    ConfigErrors& errors;
    std::map<std::string, GivenPlace, std::less<>> places; ///< by key
    const StudyFiles& files;                               ///< that are at hand already

    /// The section's table; null if it is absent (or no table, which is recorded elsewhere).
    [[nodiscard]] const toml::table* section(std::string_view name) const {
        const toml::node* node = root.get(name);
        return node != nullptr ? node->as_table() : nullptr;
    }
    /// Notes that `key` is given there; records an error if it was given before.
    void note_given(const std::string& key, const GivenPlace& place);
};

// The sections, one function each (config_sections.cpp, config_factors.cpp). Every function
// records what is wrong and goes on.
void read_study(ConfigContext& context);
void read_effects(ConfigContext& context); ///< after the study's kind, before the factors
void read_stem_and_release(ConfigContext& context);
void read_law(ConfigContext& context);
void read_integrator(ConfigContext& context);
void read_vibration(ConfigContext& context); ///< after the integrator, whose step must fit
void read_reduce(ConfigContext& context);    ///< after the vibration, whose duration it needs
void read_archive(ConfigContext& context);
void read_timestep(ConfigContext& context);    ///< after the study, whose kind decides
void read_design(ConfigContext& context);      ///< before the factors
void read_replicates(ConfigContext& context);  ///< after the design, before the factors
void read_factors(ConfigContext& context);     ///< the [[design.point]] tables included
void read_correlation(ConfigContext& context); ///< after the factors

} // namespace culm::study
