// SPDX-License-Identifier: BSD-3-Clause
#include "fit/many_fits.hpp"

#include "fit/coarse_image.hpp"
#include "fit/fit_model.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

namespace culm::fit {
namespace {

/// Of what a fit gains, that may be missing on a coarse chain: of the fits to two hidden effects at
/// most 0.1 % was with 20 spheres and 0.3 % with 14.
constexpr double image_error = 0.005;

/// χ² so far above `best` that a model that does not come down to it is neither better nor a rival:
/// what decides is a few dozen, counted by the best model's reduced χ² and by the share of the
/// readings that are independent.
double within_reach(double best, std::size_t readings) {
    constexpr double generous = 300.0;
    return best +
           generous * std::max(1.0, best / static_cast<double>(std::max<std::size_t>(readings, 1)));
}

/// (plans)(starts), as FitPlan::begin().
using BegunStarts = std::vector<std::vector<std::optional<BegunStart>>>;

double smallest_begun(const BegunStarts& begun) {
    double smallest = std::numeric_limits<double>::infinity();
    for (const std::vector<std::optional<BegunStart>>& starts : begun)
        for (const std::optional<BegunStart>& start : starts)
            if (start)
                smallest = std::min(smallest, start->chi_squared);
    return smallest;
}

class CandidateFits {
  public:
    CandidateFits(const std::vector<SelectedEffects>& models, const Fit& smaller,
                  std::span<const ObservedRecording> recordings, const FitOptions& options,
                  const core::ItemMap& map)
        : models_(models), smaller_(smaller), recordings_(recordings), options_(options), map_(map),
          image_(smaller, recordings, options) {
        for (const SelectedEffects& effects : models)
            costs_.push_back(relative_cost(effects));
    }

    [[nodiscard]] std::vector<Fit> run(const FitGoal& goal) {
        fit_image(goal);
        if (image_.is_coarser())
            refine();
        return std::move(fits_);
    }

  private:
    [[nodiscard]] BegunStarts begun(const std::vector<FitPlan>& plans) const {
        std::vector<std::pair<std::size_t, std::size_t>> items; // plan and start
        std::vector<double> costs;
        for (std::size_t k = 0; k < plans.size(); ++k)
            for (std::size_t start = 0; start < plans[k].start_count(); ++start) {
                items.emplace_back(k, start);
                costs.push_back(costs_[k]);
            }
        BegunStarts begun(plans.size());
        if (items.empty())
            return begun;
        std::vector<std::optional<std::optional<BegunStart>>> answers =
            map_.values(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
                const auto [plan, start] = items[item];
                return plans[plan].begin(start,
                                         image_.options(with_heartbeat(options_, heartbeat)));
            });
        for (std::size_t item = 0; item < items.size(); ++item)
            begun[items[item].first].push_back(std::move(answers[item]).value_or(std::nullopt));
        return begun;
    }

    void set_reach(const FitGoal& goal, double smallest_begun) {
        // Fits that cannot win are stopped early. The aim is the best that is known now, so a
        // stopped fit was beaten by something that exists.
        const double aim =
            goal.is_of_best ? std::min(goal.chi_squared, smallest_begun) : goal.chi_squared;
        if (!std::isfinite(aim) || smaller_.failed() || !smaller_.is_noise_known_everywhere())
            return;
        reach_ = goal.is_of_best ? within_reach(aim, smaller_.readings) : aim;
        if (image_.is_coarser())
            *reach_ += image_error * std::max(0.0, smaller_.chi_squared - aim);
    }

    void fit_image(const FitGoal& goal) {
        std::vector<FitPlan> plans;
        for (const SelectedEffects& effects : models_)
            plans.emplace_back(effects, image_.fit(), image_.recordings(),
                               image_.options(options_));
        const BegunStarts starts = begun(plans);
        set_reach(goal, smallest_begun(starts));
        std::vector<std::optional<Fit>> answers =
            map_.values(costs_, [&](std::size_t item, const run::Heartbeat& heartbeat) {
                FitOptions own = image_.options(with_heartbeat(options_, heartbeat));
                own.wanted_chi_squared = reach_;
                return image_.as_fine(numbers_of(plans[item].finish(starts[item], own)));
            });
        for (std::size_t k = 0; k < models_.size(); ++k)
            fits_.push_back(arrived(std::move(answers[k]), models_[k]));
    }

    /// From where the coarse chain has ended; all the way if it has failed.
    [[nodiscard]] Fit refined_fit(std::size_t k, const FitOptions& options) const {
        const SelectedEffects& effects = models_[k];
        return fits_[k].is_fitted() ? refined(models_of(fits_[k], recordings_, options), effects,
                                              smaller_, recordings_, options)
                                    : fit_model(effects, smaller_, recordings_, options);
    }

    void refine() {
        std::vector<std::size_t> places;
        std::vector<double> costs;
        for (std::size_t k = 0; k < fits_.size(); ++k) {
            if (fits_[k].is_fitted() && reach_ && fits_[k].chi_squared > *reach_) {
                fits_[k].status = FitStatus::Stopped;
                fits_[k].out_of_reach = reach_;
            }
            if (fits_[k].out_of_reach || !fits_[k].moves())
                continue;
            places.push_back(k);
            costs.push_back(costs_[k]);
        }
        if (places.empty())
            return;
        std::vector<std::optional<Fit>> answers =
            map_.values(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
                return numbers_of(refined_fit(places[item], with_heartbeat(options_, heartbeat)));
            });
        for (std::size_t item = 0; item < places.size(); ++item) {
            Fit& fit = fits_[places[item]];
            const int before = fit.runs;
            fit = arrived(std::move(answers[item]), models_[places[item]]);
            fit.runs += before;
        }
    }

    const std::vector<SelectedEffects>& models_;
    const Fit& smaller_;
    std::span<const ObservedRecording> recordings_;
    const FitOptions& options_;
    const core::ItemMap& map_;
    CoarseImage image_;
    std::vector<double> costs_;   ///< (models)
    std::optional<double> reach_; ///< χ² that a fit must come below to be followed
    std::vector<Fit> fits_;
};

} // namespace

std::vector<Fit> fit_candidates(const std::vector<SelectedEffects>& models, const Fit& smaller,
                                std::span<const ObservedRecording> recordings,
                                const FitOptions& options, const core::ItemMap& map,
                                const FitGoal& goal) {
    if (models.empty())
        return {};
    return CandidateFits(models, smaller, recordings, options, map).run(goal);
}

double relative_cost(const SelectedEffects& effects) {
    constexpr double of_spatial = 6.0;
    return std::ranges::any_of(effects,
                               [](const auto& each) { return each.effect->dimensions() > 2; })
               ? of_spatial
               : 1.0;
}

} // namespace culm::fit
