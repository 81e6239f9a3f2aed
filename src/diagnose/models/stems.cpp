// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/models/stems.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>

#include <fmt/format.h>

namespace culm::diagnose {
namespace {

/// Up to this number of stems the results of runs travel with a fit: about 0.2 MB for a stem.
constexpr std::size_t few_stems = 8;
constexpr std::size_t wanted_items = 40;

fit::BaselineFit baseline_of(const ObservedStem& stem, const fit::FitOptions& options) {
    return {stem.recordings, fit::rerun(stem.chain, stem.recordings, options)};
}

} // namespace

std::vector<Specimen> specimens_of(std::span<const measure::Measurement> measurements) {
    std::vector<Specimen> specimens;
    for (const measure::Measurement& recording : measurements) {
        const std::string& name = recording.specimen_name();
        auto found = std::ranges::find(specimens, name, &Specimen::name);
        if (found == specimens.end())
            found = specimens.insert(specimens.end(), {name, recording.rig, {}});
        if (found->rig != recording.rig)
            throw core::InputError(
                fmt::format("{} and {} are recordings of specimen \"{}\" on different rigs "
                            "(\"{}\", \"{}\"): a stem of a laboratory is on one rig; diagnose the "
                            "specimen alone, or correct stem.rig in stem.toml",
                            found->recordings.front().stem.id, recording.stem.id, name, found->rig,
                            recording.rig));
        found->recordings.push_back(recording);
    }
    return specimens;
}

Stems::Stems(std::span<const Specimen> specimens, const DiagnosisOptions& options)
    : specimens_(specimens), options_(options) {
    options.report(is_one() ? "fitting the published chain"
                            : fmt::format("fitting the published chain to {} stems", size()));
    stems_.resize(specimens.size());
    std::vector<std::size_t> all(specimens.size());
    std::iota(all.begin(), all.end(), 0);
    add_baselines(all, [&](std::size_t s, const fit::FitOptions& fit_options) {
        return fit::fit_baseline(specimens_[s].recordings, fit_options);
    });
    if (fitted().empty())
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   is_one() ? "the model cannot be fitted: " + stems_[0].failure
                                            : "no stem can be fitted; the first one: " +
                                                  stems_[0].failure);
}

Stems::Stems(std::span<const Specimen> specimens, const DiagnosisOptions& options,
             std::vector<ObservedStem> stems)
    : specimens_(specimens), options_(options), stems_(std::move(stems)) {}

template <class Work>
void Stems::add_baselines(const std::vector<std::size_t>& of, const Work& work) {
    std::vector<ObservedStem> found =
        map(of, [&](std::size_t item, const fit::FitOptions& fit_options) -> ObservedStem {
            try {
                return observed_stem(work(of[item], fit_options));
            } catch (const core::NumericalError& error) {
                return {error.what(), {}, {}, {}};
            }
        });
    for (std::size_t k = 0; k < of.size(); ++k)
        take(of[k], std::move(found[k]));
    std::map<std::string, int> rigs;
    std::map<std::string, int> terms;
    for (const std::size_t s : fitted()) {
        if (!specimens_[s].rig.empty())
            ++rigs[specimens_[s].rig];
        std::set<std::string> own;
        for (const fit::Pull& pull : stems_[s].chain.pulls)
            if (!fit::is_of_row(pull.kind))
                own.insert(pull.id);
        for (const std::string& name : own)
            ++terms[name];
    }
    shared_terms_.clear();
    for (const auto& [name, count] : terms)
        if (count > 1)
            shared_terms_.push_back(name);
    for (const auto& [rig, count] : rigs)
        if (count > 1)
            rigs_.insert(rig);
}

std::vector<std::size_t> Stems::fitted() const {
    std::vector<std::size_t> out;
    for (std::size_t s = 0; s < size(); ++s)
        if (!is_left_out(s))
            out.push_back(s);
    return out;
}

std::vector<std::size_t> Stems::on_rig(const std::string& rig) const {
    std::vector<std::size_t> out = fitted();
    std::erase_if(out, [&](std::size_t s) { return specimens_[s].rig != rig; });
    return out;
}

fit::Fit Stems::to_message(const fit::Fit& fit) const {
    return size() <= few_stems ? fit::to_numbers_with_points(fit) : fit::to_numbers(fit);
}

std::size_t Stems::parts_per_stem(std::size_t candidates) const {
    return std::clamp<std::size_t>(wanted_items / size(), 1, std::max<std::size_t>(1, candidates));
}

bool Stems::estimate_noise(const std::vector<fit::Fit>& best) {
    const std::vector<std::size_t> of = fitted();
    auto found = map(
        of, [&](std::size_t item, const fit::FitOptions& options) -> std::optional<ObservedStem> {
            const ObservedStem& stem = stems_[of[item]];
            const std::optional<fit::BaselineFit> again = fit::baseline_with_noise_about(
                fit::rerun(best[of[item]], stem.recordings, options), baseline_of(stem, options),
                specimens_[of[item]].recordings, options);
            return again && !again->fit.failed() ? std::optional(observed_stem(*again))
                                                 : std::nullopt;
        });
    bool is_other = false;
    for (std::size_t k = 0; k < of.size(); ++k)
        if (found[k]) {
            take(of[k], *std::move(found[k]));
            is_other = true;
        }
    return is_other;
}

Stems Stems::with_chain(const DiagnosisOptions& options) const {
    Stems out(specimens_, options, stems_);
    out.add_baselines(fitted(), [&](std::size_t s, const fit::FitOptions& fit_options) {
        const fit::FitOptions from = fit::with_heartbeat(options_.candidate, fit_options.heartbeat);
        return fit::baseline_with_chain(baseline_of(stems_[s], from), from,
                                        specimens_[s].recordings, fit_options);
    });
    return out;
}

ObservedStem Stems::observed_stem(const fit::BaselineFit& baseline) const {
    if (baseline.fit.failed())
        return {baseline.fit.reason, {}, {}, {}};
    ObservedStem out{{}, baseline.recordings, to_message(baseline.fit), {}};
    for (const fit::RecordingFit& part : baseline.fit.parts)
        out.noise.push_back(part.noise);
    return out;
}

/// Completes what another rank found.
void Stems::take(std::size_t stem, ObservedStem found) {
    for (std::size_t m = 0; m < found.recordings.size(); ++m)
        static_cast<measure::Measurement&>(found.recordings[m]) = specimens_[stem].recordings[m];
    stems_[stem] = std::move(found);
}

double Stems::seconds_of(std::size_t stem) const {
    double seconds = 0.0;
    for (const measure::Measurement& recording : specimens_[stem].recordings)
        seconds += recording.times.back();
    return seconds;
}

} // namespace culm::diagnose
