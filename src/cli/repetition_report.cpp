// SPDX-License-Identifier: BSD-3-Clause
#include "cli/repetition_report.hpp"

#include "cli/archive_text.hpp"
#include "cli/json_output.hpp"

#include <fmt/core.h>

namespace culm::cli {
namespace {

std::string facts_text(const study::Repetition& repetition) {
    std::string text;
    for (const study::Repetition::Fact& fact : repetition.facts)
        if (fact.archived == fact.now)
            text += fmt::format("{:10} {}\n", fact.name, fact.now);
        else
            text += fmt::format("{:10} {} (archived)\n{:10} {} (now)\n", fact.name, fact.archived,
                                "", fact.now);
    return text;
}

} // namespace

std::string repetition_text(const study::Repetition& repetition) {
    std::string text = facts_text(repetition);
    if (repetition.missing > 0)
        text += fmt::format("{} points are missing in the archive and were not compared\n",
                            repetition.missing);
    if (repetition.is_identical())
        return text + fmt::format("identical  bit for bit: {} points, {} columns and histories\n",
                                  repetition.points, repetition.datasets);
    if (!repetition.other_outcomes.empty())
        text += fmt::format("differs    other outcome of points {}\n",
                            ranges_text(repetition.other_outcomes));
    for (const study::DifferingNumbers& numbers : repetition.differing)
        text += fmt::format("differs    {}: {} of {} points, by at most {:.3g} {} (relative "
                            "{:.2g}), first at point {}\n",
                            numbers.name, numbers.points, repetition.points, numbers.largest,
                            numbers.unit, numbers.largest_relative, numbers.first_point);
    return text + fmt::format("differs    {} of {} columns and histories\n",
                              repetition.differing.size(), repetition.datasets);
}

bool report_repetition(const study::StudyFolder& archived, const study::StudyFolder& now) {
    const study::Repetition repetition = study::compare_archives(
        archive::StudyFile(archived.archive()), archive::StudyFile(now.archive()));
    write_json((now.path() / "repetition.json").string(), study::to_json(repetition));
    fmt::print("\ncompared with {}\n{}", archived.archive().string(), repetition_text(repetition));
    return repetition.is_identical();
}

} // namespace culm::cli
