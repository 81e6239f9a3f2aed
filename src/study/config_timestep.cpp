// SPDX-License-Identifier: BSD-3-Clause
// The section of time-step studies, and the keys that such studies have no use for.
#include "study/config_context.hpp"
#include "study/config_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace culm::study {

namespace {

struct KeyPlace {
    const char* section;
    const char* key;
};

/// What a time-step study chooses itself: its steps, its record, and what it keeps.
constexpr std::array keys_of_vibrations{KeyPlace{"study", "heights_mm"},
                                        KeyPlace{"integrator", "method"},
                                        KeyPlace{"integrator", "timestep_s"},
                                        KeyPlace{"integrator", "relative_tolerance"},
                                        KeyPlace{"vibration", "duration_s"},
                                        KeyPlace{"vibration", "sample_interval_s"},
                                        KeyPlace{"reduce", "window_s"},
                                        KeyPlace{"reduce", "significance"},
                                        KeyPlace{"archive", "trajectory_compression"}};

constexpr std::array keys_of_comparisons{"record_cycles", "samples_per_cycle",
                                         "reference_tolerance"};

TableReader reader_of(const char* section, ConfigContext& context) {
    return {context.section(section), section, section, context.errors};
}

void refuse_keys_of_vibrations(ConfigContext& context) {
    for (const KeyPlace& place : keys_of_vibrations) {
        const TableReader reader = reader_of(place.section, context);
        if (reader.has(place.key))
            reader.error(place.key, "only with study.kind = \"vibration\"");
    }
    if (context.config.base.store != run::StoreLevel::Fit)
        reader_of("study", context)
            .error("store", "study.kind = \"timestep\" keeps no histories: \"fit\" or nothing");
}

void read_fractions(const TableReader& reader, ConfigContext& context) {
    std::vector<double>& fractions = context.config.timestep.fractions;
    fractions = reader.numbers("fractions").value_or(std::vector<double>());
    std::ranges::sort(fractions);
    if (const auto twice = std::ranges::adjacent_find(fractions); twice != fractions.end())
        reader.error("fractions", fmt::format("must name {} once only", *twice));
    for (const char* key : keys_of_comparisons)
        if (!reader.has("fractions") && reader.has(key))
            reader.error(key, "only with timestep.fractions");
}

} // namespace

void read_timestep(ConfigContext& context) {
    const TableReader reader = reader_of("timestep", context);
    reader.refuse_unknown_keys();
    if (context.config.kind != StudyKind::Timestep) {
        for (const ConfigKey& key : config_keys_of("timestep"))
            if (reader.has(key.key))
                reader.error(key.key, "only with study.kind = \"timestep\"");
        return;
    }
    refuse_keys_of_vibrations(context);
    TimestepOptions& options = context.config.timestep;
    options.limit_tolerance = reader.number("limit_tolerance").value_or(options.limit_tolerance);
    const auto fewest = static_cast<std::int64_t>(std::ceil(20.0 / options.limit_tolerance));
    options.trial_steps =
        reader.whole_number("trial_steps").value_or(std::max(options.trial_steps, fewest));
    if (options.trial_steps < fewest)
        reader.error("trial_steps",
                     fmt::format("must be at least 20/limit_tolerance = {}", fewest));
    read_fractions(reader, context);
    options.record_cycles = reader.number("record_cycles").value_or(options.record_cycles);
    options.samples_per_cycle =
        reader.whole_number("samples_per_cycle").value_or(options.samples_per_cycle);
    options.reference_tolerance =
        reader.number("reference_tolerance").value_or(options.reference_tolerance);
}

} // namespace culm::study
