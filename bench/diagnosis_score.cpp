// SPDX-License-Identifier: BSD-3-Clause
#include "bench/diagnosis_score.hpp"

#include "physics/effects/library.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <boost/math/distributions/binomial.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::bench {
namespace {

using Names = std::set<std::string>;

Names hidden_names(const beam::RandomCase& drawn) {
    Names names;
    for (const beam::HiddenEffect& effect : drawn.spec.effects)
        names.insert(effect.name);
    return names;
}

/// Rivals of a tie may be sets themselves, "a + b" or "a,b".
bool mentions(const std::string& rival, const std::string& name) {
    std::size_t at = rival.find(name);
    const auto is_part = [&rival](std::size_t place) {
        return place < rival.size() &&
               ((rival[place] >= 'a' && rival[place] <= 'z') || rival[place] == '_');
    };
    while (at != std::string::npos) {
        if (!(at > 0 && is_part(at - 1)) && !is_part(at + name.size()))
            return true;
        at = rival.find(name, at + 1);
    }
    return false;
}

const std::vector<std::string>* tie_of(const Outcome& outcome, const std::string& effect) {
    const auto found = std::ranges::find_if(
        outcome.ties, [&effect](const auto& tie) { return !tie.empty() && tie.front() == effect; });
    return found == outcome.ties.end() ? nullptr : &*found;
}

bool holds(const Outcome& outcome, const std::string& name) {
    if (std::ranges::find(outcome.effects, name) != outcome.effects.end())
        return true;
    return std::ranges::any_of(outcome.ties, [&name](const auto& tie) {
        return std::ranges::any_of(
            tie, [&name](const std::string& rival) { return mentions(rival, name); });
    });
}

/// Is each name of the answer hidden there, or tied with something that is?
bool names_nothing_else(const Outcome& outcome, const Names& hidden) {
    return std::ranges::all_of(outcome.effects, [&](const std::string& effect) {
        if (hidden.contains(effect))
            return true;
        const auto* const tie = tie_of(outcome, effect);
        return tie != nullptr && std::ranges::any_of(*tie, [&hidden](const std::string& rival) {
                   return std::ranges::any_of(
                       hidden, [&rival](const std::string& name) { return mentions(rival, name); });
               });
    });
}

/// The family of a library's effect, and of the law outside it that is of the same kind.
std::optional<physics::Family> family_of(const std::string& hidden) {
    if (hidden == "cubic_drag")
        return physics::Family::Air;
    if (hidden == "curvature_damping")
        return physics::Family::MaterialDamping;
    const std::vector<std::string> names = physics::effect_names();
    if (std::ranges::find(names, hidden) == names.end())
        return std::nullopt;
    return physics::effect_named(hidden)->family();
}

/// Are the families of the answer those of what is hidden, with every hidden effect among the
/// members, or, of a law outside the library, with none named alone?
bool names_the_families(const Outcome& outcome, const beam::RandomCase& drawn) {
    std::multiset<std::string> named;
    std::multiset<std::string> hidden;
    bool holds_members = true;
    for (const FoundFamily& found : outcome.families)
        named.insert(found.family);
    for (const std::string& name : hidden_names(drawn)) {
        const std::optional<physics::Family> family = family_of(name);
        if (!family)
            return false;
        hidden.emplace(to_string(*family));
        holds_members = holds_members && std::ranges::any_of(outcome.families, [&](const auto& of) {
                            return drawn.kind == beam::CaseKind::Unknown
                                       ? of.members.size() > 1
                                       : std::ranges::find(of.members, name) != of.members.end();
                        });
    }
    return outcome.verdict == "effect" && holds_members && named == hidden;
}

using Tally = std::array<int, grade_count>;

int& at(Tally& tally, Grade grade) {
    return tally[static_cast<std::size_t>(grade)];
}
int at(const Tally& tally, Grade grade) {
    return tally[static_cast<std::size_t>(grade)];
}

std::string percent(int hits, int trials) {
    return trials == 0 ? std::string("–")
                       : fmt::format("{:.0f} % ({}/{})", 100.0 * hits / trials, hits, trials);
}

double median(std::vector<double> values) {
    if (values.empty())
        return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
}

/// What a row of a table sums up.
struct Row {
    int cases = 0;
    Tally tally{};
    std::vector<double> misfits; ///< of the baseline, over the noise
    std::vector<double> errors;  ///< of parameters, relative
    int covered = 0;             ///< truths within 90 % intervals
    int intervals = 0;
    std::vector<double> tie_sizes;
    std::map<std::string, int> instead; ///< answers other than the truth
};

std::string answer(const Outcome& outcome) {
    if (outcome.verdict != "effect" && outcome.verdict != "tie")
        return outcome.verdict;
    std::string text;
    for (const std::string& effect : outcome.effects) {
        text += text.empty() ? "" : " + ";
        text += effect;
        if (const auto* const tie = tie_of(outcome, effect))
            text += fmt::format(" (or {})", fmt::join(tie->begin() + 1, tie->end(), ", "));
    }
    return text;
}

/// Parameters of hidden effects that the final model contains.
void add_parameters(const GradedCase& graded, Row& row) {
    constexpr double ninety_percent = 1.6449; // of the normal distribution, two-sided
    for (const beam::HiddenEffect& effect : graded.drawn.spec.effects)
        for (const auto& [name, truth] : effect.parameters) {
            const auto found = std::ranges::find(graded.outcome.parameters,
                                                 effect.name + "." + name, &FoundParameter::name);
            if (found == graded.outcome.parameters.end() || truth == 0.0)
                continue;
            const double error = found->value - truth;
            row.errors.push_back(std::abs(error / truth));
            ++row.intervals;
            row.covered += std::abs(error) <= ninety_percent * found->standard_error ? 1 : 0;
        }
}

void add(const GradedCase& graded, Row& row) {
    ++row.cases;
    ++at(row.tally, graded.grade);
    row.misfits.push_back(graded.outcome.baseline_misfit);
    for (const auto& tie : graded.outcome.ties)
        row.tie_sizes.push_back(static_cast<double>(tie.size()));
    if (graded.grade == Grade::Right || graded.grade == Grade::Family ||
        graded.grade == Grade::HonestTie || graded.grade == Grade::Partly)
        add_parameters(graded, row);
    if (graded.grade != Grade::Right)
        ++row.instead[answer(graded.outcome)];
}

constexpr const char* head = "| {} | cases | right | family | honest tie | partly | silent | "
                             "unknown | wrong tie | wrong | failed | "
                             "baseline misfit | parameter error | 90 % intervals |\n"
                             "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";

std::string line(const std::string& name, const Row& row) {
    std::string text = fmt::format("| {} | {} |", name, row.cases);
    for (const int count : row.tally)
        text += fmt::format(" {} |", count);
    text += fmt::format(" {:.2f} |", median(row.misfits));
    text += row.errors.empty() ? std::string(" – | – |\n")
                               : fmt::format(" {:.1f} % | {} |\n", 100.0 * median(row.errors),
                                             percent(row.covered, row.intervals));
    return text;
}

std::string misfit_band(double misfit) {
    if (misfit < 1.02)
        return "below 1.02";
    if (misfit < 1.1)
        return "1.02 … 1.1";
    if (misfit < 1.5)
        return "1.1 … 1.5";
    return misfit < 5.0 ? "1.5 … 5" : "5 and more";
}

std::string key_of(const beam::RandomCase& drawn) {
    std::string key;
    for (const std::string& name : hidden_names(drawn)) {
        key += key.empty() ? "" : " + ";
        key += name;
    }
    return key.empty() ? std::string("nothing") : key;
}

std::string instead_lines(const std::map<std::string, Row>& rows) {
    std::string text;
    for (const auto& [name, row] : rows)
        for (const auto& [other, count] : row.instead)
            text += fmt::format("- {}: {} × {}\n", name, count, other);
    return text.empty() ? text : fmt::format("\nAnswers other than the truth alone:\n\n{}", text);
}

std::string null_lines(const Row& all) {
    const int named = all.cases - at(all.tally, Grade::Right) - at(all.tally, Grade::Failed);
    return fmt::format("\nFalse alarms: {}; 95 % upper bound {:.1f} %. Of these names: {}.\n",
                       percent(named, all.cases), 100.0 * upper_bound(named, all.cases),
                       at(all.tally, Grade::Wrong));
}

/// Rates of the effects that show: baseline misfit above 1.5 times the noise.
std::string visible_lines(beam::CaseKind kind, const Row& visible) {
    const int right = at(visible.tally, Grade::Right);
    const int known = right + at(visible.tally, Grade::Family);
    const int held = known + at(visible.tally, Grade::HonestTie);
    const int wrong = at(visible.tally, Grade::Wrong) + at(visible.tally, Grade::WrongTie);
    std::string text = fmt::format(
        "\nBaseline misfit above 1.5 × noise: named exactly {}, by member or family {}; named or "
        "in "
        "an honest tie {}; wrong {}, with confidence {}; median tie of {:.0f}.\n",
        percent(right, visible.cases), percent(known, visible.cases), percent(held, visible.cases),
        percent(wrong, visible.cases), percent(at(visible.tally, Grade::Wrong), visible.cases),
        median(visible.tie_sizes));
    if (kind == beam::CaseKind::Unknown)
        text =
            fmt::format("\nBaseline misfit above 1.5 × noise: called unknown {}, by family {}.\n",
                        percent(right, visible.cases),
                        percent(at(visible.tally, Grade::Family), visible.cases));
    return text;
}

std::string kind_report(beam::CaseKind kind, const std::vector<GradedCase>& cases) {
    std::map<std::string, Row> by_truth;
    std::map<std::string, Row> by_misfit;
    Row all;
    Row visible;
    std::vector<double> seconds;
    for (const GradedCase& graded : cases) {
        if (graded.drawn.kind != kind)
            continue;
        add(graded, all);
        add(graded, by_truth[key_of(graded.drawn)]);
        add(graded, by_misfit[misfit_band(graded.outcome.baseline_misfit)]);
        if (graded.outcome.baseline_misfit > 1.5)
            add(graded, visible);
        seconds.push_back(graded.outcome.seconds);
    }
    if (all.cases == 0)
        return {};
    std::string text = fmt::format("\n## {}\n\n", beam::to_string(kind));
    text += fmt::format(fmt::runtime(head), "hidden");
    for (const auto& [name, row] : by_truth)
        text += line(name, row);
    text += line("all", all);
    if (kind != beam::CaseKind::Null) {
        text += '\n';
        text += fmt::format(fmt::runtime(head), "baseline misfit");
        for (const auto& [name, row] : by_misfit)
            text += line(name, row);
    }
    text += kind == beam::CaseKind::Null ? null_lines(all) : visible_lines(kind, visible);
    text += fmt::format("Processor time of a diagnosis: median {:.1f} s, longest {:.1f} s.\n",
                        median(seconds), *std::ranges::max_element(seconds));
    return text + instead_lines(by_truth);
}

} // namespace

std::string_view to_string(Grade grade) {
    constexpr std::array<std::string_view, grade_count> words{"right",     "family", "honest tie",
                                                              "partly",    "silent", "unknown",
                                                              "wrong tie", "wrong",  "failed"};
    return words[static_cast<std::size_t>(grade)];
}

Grade grade(const beam::RandomCase& drawn, const Outcome& outcome) {
    const Names hidden = hidden_names(drawn);
    if (outcome.verdict == "failed")
        return Grade::Failed;
    if (outcome.verdict == "adequate")
        return hidden.empty() ? Grade::Right : Grade::Silent;
    if (outcome.verdict == "unknown")
        return drawn.kind == beam::CaseKind::Unknown ? Grade::Right : Grade::Unknown;
    const bool is_open = std::ranges::any_of(
        outcome.families, [](const FoundFamily& of) { return of.members.size() > 1; });
    if (is_open && names_the_families(outcome, drawn))
        return Grade::Family;
    const bool is_tie = !outcome.ties.empty() || outcome.verdict == "tie";
    const Names named(outcome.effects.begin(), outcome.effects.end());
    if (!is_tie && named == hidden)
        return Grade::Right;
    if (hidden.empty() || !names_nothing_else(outcome, hidden))
        return is_tie ? Grade::WrongTie : Grade::Wrong;
    const bool holds_all = std::ranges::all_of(
        hidden, [&outcome](const std::string& name) { return holds(outcome, name); });
    return holds_all ? Grade::HonestTie : Grade::Partly;
}

double upper_bound(int hits, int trials) {
    if (trials == 0 || hits == trials)
        return 1.0;
    return boost::math::binomial_distribution<>::find_upper_bound_on_p(trials, hits, 0.05);
}

std::string report(const std::vector<GradedCase>& cases) {
    std::string text;
    for (const beam::CaseKind kind : {beam::CaseKind::Null, beam::CaseKind::Single,
                                      beam::CaseKind::Pair, beam::CaseKind::Unknown})
        text += kind_report(kind, cases);
    return text;
}

} // namespace culm::bench
