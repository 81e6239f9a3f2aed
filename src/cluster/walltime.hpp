// SPDX-License-Identifier: BSD-3-Clause
// Durations as batch systems and people write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace culm::cluster {

/// Seconds of a duration: HH:MM:SS, MM:SS, D-HH, D-HH:MM, D-HH:MM:SS, or a number with its unit,
/// 90s, 45min, 12h, 2d. A number alone is refused, because
/// Slurm reads it as minutes and PBS as seconds. Throws core::InputError, with a text that begins
/// with `what`, for any other form and for a duration that is not above zero.
[[nodiscard]] double parse_walltime(std::string_view what, const std::string& text);

/// Seconds left of a job as squeue prints them (TimeLeft); empty for UNLIMITED, INVALID, NOT_SET.
[[nodiscard]] std::optional<double> parse_time_left(std::string_view text);

/// HH:MM:SS, with days in front for a day and more (Slurm's form).
[[nodiscard]] std::string walltime_text(double seconds);

/// HHH:MM:SS for any number of hours (PBS's form).
[[nodiscard]] std::string walltime_text_in_hours(double seconds);

} // namespace culm::cluster
