// SPDX-License-Identifier: BSD-3-Clause
// Durations as batch systems and people write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace culm::cluster {

/// The forms that parse_walltime takes, for messages.
inline constexpr std::string_view walltime_forms =
    "HH:MM:SS, MM:SS, D-HH, D-HH:MM, D-HH:MM:SS, or a number with its unit: 90s, 45min, 12h, 2d";

/// Seconds of a duration that is written in one of these forms. A number alone is refused, because
/// Slurm takes it for minutes and PBS for seconds. Throws core::InputError, which begins with
/// `what`, if it is none of them or not above zero.
[[nodiscard]] double parse_walltime(std::string_view what, const std::string& text);

/// Seconds left of a job as squeue prints them (TimeLeft), or nothing: UNLIMITED, INVALID, NOT_SET.
[[nodiscard]] std::optional<double> parse_time_left(std::string_view text);

/// HH:MM:SS, with days in front from a day up (Slurm's form).
[[nodiscard]] std::string walltime_text(double seconds);

/// HHH:MM:SS however many hours (PBS's form).
[[nodiscard]] std::string walltime_text_in_hours(double seconds);

} // namespace culm::cluster
