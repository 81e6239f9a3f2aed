// SPDX-License-Identifier: BSD-3-Clause
// Every key of study files, each declared once (core/toml/key.hpp).
#pragma once

#include "core/toml/key.hpp"
#include "study/config/study_config.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace culm::study {

using core::KeyDescription;

/// The tables whose keys set members of the configuration, in the order of the documentation.
/// [stem] and [release] have the rows of parameters.hpp, [factors] and [[design.point]] take any of
/// these.
[[nodiscard]] const std::vector<core::KeyTable<StudyConfig>>& study_tables();

enum class Spacing { Linear, Log };
enum class DrawnFrom { Normal, Lognormal, Uniform, Empirical };
enum class Rows { Independent, Together };
enum class Level { Stem, Test };

/// The inline table of one factor as it is written; numbers are in the unit of the parameter.
struct FactorEntry {
    std::optional<double> from;
    std::optional<double> to;
    std::optional<double> step;
    std::optional<std::int64_t> count;
    Spacing spacing = Spacing::Linear;
    std::optional<DrawnFrom> distribution;
    std::optional<double> mean;
    std::optional<double> sd;
    std::optional<double> min;
    std::optional<double> max;
    std::string file;
    std::string column;
    std::string unit;
    Rows rows = Rows::Independent;
    Level level = Level::Stem;
    std::optional<double> within_sd;
};

/// The keys of the table of one factor.
[[nodiscard]] const core::KeyTable<FactorEntry>& factor_table();

/// Every key, table by table.
[[nodiscard]] std::vector<KeyDescription> config_keys();

/// The row of the parameter as text.
[[nodiscard]] KeyDescription description_of(const Parameter& parameter);

} // namespace culm::study
