// SPDX-License-Identifier: BSD-3-Clause
// The stems of a diagnosis: their recordings, their published chains, and work on them that is
// distributed over ranks. One specimen is a laboratory of one stem.
#pragma once

#include "core/item_map.hpp"
#include "diagnose/policy.hpp"
#include "fit/fit_model.hpp"
#include "fit/fit_numbers.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// A stem with its recordings.
struct Specimen {
    std::string name;
    std::string rig; ///< empty: not stated, so that it shares nothing
    std::vector<measure::Measurement> recordings;
};

/// The recordings by specimen, in the order of first appearance.
/// Throws core::InputError if a specimen was recorded on two rigs.
[[nodiscard]] std::vector<Specimen>
specimens_of(std::span<const measure::Measurement> measurements);

struct DiagnosisOptions {
    fit::FitOptions candidate;
    fit::SelectedEffects known;      ///< that certainly act; part of every model
    fit::SelectedEffects candidates; ///< in the library's order
    std::size_t most_effects = 3;
    core::ItemMap map;
    std::function<void(const std::string&)> progress; ///< receives the next step; may be empty
    Policy policy;

    /// Index of the candidate of this name; their number if there is none.
    [[nodiscard]] std::size_t place_of(const std::string& effect) const {
        const auto is_named = [&](const auto& each) { return each.effect->name == effect; };
        return std::size_t(std::ranges::find_if(candidates, is_named) - candidates.begin());
    }
    void report(const std::string& next) const {
        if (progress)
            progress(next);
    }
};

/// The published chain of a stem.
struct ObservedStem {
    std::string failure; ///< why the chain could not be fitted; empty if it could
    std::vector<fit::ObservedRecording> recordings; ///< with the noise and the error terms
    fit::Fit chain;                                 ///< numbers
    std::vector<std::vector<double>> noise;         ///< as JointOptions::noise
};

class Stems {
  public:
    /// Fits the published chain to every stem; one whose chain cannot be fitted is left out. Throws
    /// core::NumericalError if no stem can be fitted.
    Stems(std::span<const Specimen> specimens, const DiagnosisOptions& options);

    [[nodiscard]] std::size_t size() const { return specimens_.size(); }
    [[nodiscard]] bool is_one() const { return size() == 1; }
    [[nodiscard]] const Specimen& specimen(std::size_t stem) const { return specimens_[stem]; }
    [[nodiscard]] const ObservedStem& operator[](std::size_t stem) const { return stems_[stem]; }
    [[nodiscard]] const DiagnosisOptions& options() const { return options_; }
    [[nodiscard]] bool is_left_out(std::size_t stem) const { return !stems_[stem].failure.empty(); }
    /// Those that are not left out.
    [[nodiscard]] std::vector<std::size_t> fitted() const;
    /// Those of them on a rig.
    [[nodiscard]] std::vector<std::size_t> on_rig(const std::string& rig) const;
    /// Rigs with two fitted stems or more, which share numbers.
    [[nodiscard]] const std::set<std::string>& rigs() const { return rigs_; }
    /// Names of the error terms that several stems have.
    [[nodiscard]] const std::vector<std::string>& shared_terms() const { return shared_terms_; }

    /// A fit as it travels. With few stems it takes the results of its runs along, from which
    /// rerun() needs no run; of many stems they would fill the memory.
    [[nodiscard]] fit::Fit to_message(const fit::Fit& fit) const;
    /// Number of items by which the columns of `candidates` about one stem are computed: about
    /// forty items in all, whatever the number of ranks.
    [[nodiscard]] std::size_t parts_per_stem(std::size_t candidates) const;

    /// Chains with the noise in motion about these fits, (stems) numbers; false if no noise is
    /// another.
    [[nodiscard]] bool estimate_noise(const std::vector<fit::Fit>& best);
    /// The same stems with the chain of other options, from the chains of these.
    [[nodiscard]] Stems with_chain(const DiagnosisOptions& options) const;

    /// work(item, options) for each item, which is work on one stem (`of`). `efforts` (items):
    /// relative to each other on the same stem; empty: equal.
    template <class Work>
    [[nodiscard]] auto map(const std::vector<std::size_t>& of, const Work& work,
                           const std::vector<double>& efforts = {}) const {
        std::vector<double> costs;
        costs.reserve(of.size());
        for (const std::size_t stem : of)
            costs.push_back(seconds_of(stem) * (efforts.empty() ? 1.0 : efforts[costs.size()]));
        return options_.map.values(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
            return work(item, fit::with_heartbeat(options_.candidate, heartbeat));
        });
    }

  private:
    /// With the baselines of the stems `of`, of which `work(stem, options)` finds one.
    template <class Work>
    void add_baselines(const std::vector<std::size_t>& of, const Work& work);
    [[nodiscard]] ObservedStem observed_stem(const fit::BaselineFit& baseline) const;
    void take(std::size_t stem, ObservedStem found);
    [[nodiscard]] double seconds_of(std::size_t stem) const; ///< of its motion

    Stems(std::span<const Specimen> specimens, const DiagnosisOptions& options,
          std::vector<ObservedStem> stems);

    std::span<const Specimen> specimens_;
    const DiagnosisOptions& options_;
    std::vector<ObservedStem> stems_;
    std::vector<std::string> shared_terms_;
    std::set<std::string> rigs_;
};

} // namespace culm::diagnose
