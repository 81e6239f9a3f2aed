// SPDX-License-Identifier: BSD-3-Clause
#include "bench/diagnosis_confusion.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

namespace culm::bench {
namespace {

std::string said(const GradedCase& graded) {
    const Outcome& outcome = graded.outcome;
    if (graded.grade == Grade::Family)
        return "its family";
    if (graded.grade == Grade::HonestTie)
        return "tie with it";
    if (graded.grade == Grade::WrongTie)
        return "tie without";
    if (outcome.verdict != "effect")
        return outcome.verdict;
    return outcome.effects.size() == 1 ? outcome.effects.front() : "several";
}

} // namespace

std::string confusion_matrix(const std::vector<GradedCase>& cases) {
    std::map<std::string, std::map<std::string, int>> counts;
    std::set<std::string> effects;
    for (const GradedCase& graded : cases) {
        if (graded.drawn.kind != beam::CaseKind::Single)
            continue;
        const std::string& hidden = graded.drawn.spec.effects.front().name;
        ++counts[hidden][said(graded)];
        effects.insert(hidden);
        if (graded.grade == Grade::Wrong && graded.outcome.effects.size() == 1)
            effects.insert(graded.outcome.effects.front());
    }
    if (counts.empty())
        return {};
    std::vector<std::string> columns(effects.begin(), effects.end());
    std::string head = "\nConfusion matrix of single effects:\n\n| hidden \\ said |";
    for (std::size_t k = 1; k <= effects.size(); ++k)
        head += fmt::format(" {} |", k);
    for (const char* const other :
         {"its family", "tie with it", "tie without", "several", "adequate", "unknown", "failed"}) {
        head += fmt::format(" {} |", other);
        columns.emplace_back(other);
    }
    std::string text = head + "\n|---|";
    for (std::size_t k = 0; k < columns.size(); ++k)
        text += "---|";
    text += '\n';
    int number = 0;
    for (const std::string& hidden : effects) {
        text += fmt::format("| {} {} |", ++number, hidden);
        for (const std::string& column : columns)
            text += counts[hidden].contains(column) ? fmt::format(" {} |", counts[hidden][column])
                                                    : std::string(" |");
        text += '\n';
    }
    return text;
}

} // namespace culm::bench
