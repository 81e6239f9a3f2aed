// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/experiment/next_experiment.hpp"

#include "core/error.hpp"
#include "fit/fit_numbers.hpp"
#include "fit/linear/scaled_solve.hpp"
#include "fit/linear/weighted_system.hpp"
#include "physics/effects/stem_scales.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include <fmt/core.h>

namespace culm::diagnose {
namespace {

constexpr std::size_t most_experiments = 3;
constexpr double worthwhile = 1.2;    ///< times the gap of a mere repetition
constexpr double largest_pull = 0.45; ///< of the length

/// The changes of an experiment: to the stem and its release, and to the camera.
struct Change {
    std::string what;
    std::function<void(run::CaseSpec&)> apply;
    double duration = 1.0; ///< of the record, times the present one's
    double rate = 1.0;     ///< of the frames, likewise
};

Change known_mass(const run::CaseSpec& spec, double share) {
    const double mass = share * physics::mass_per_length(spec.stem) * spec.stem.free_length();
    return {fmt::format("fix a known mass of {:.3g} mg to the tip ({:.0f} % of the stem's) and "
                        "release again",
                        1e6 * mass, 100.0 * share),
            [mass](run::CaseSpec& changed) {
                changed.added_masses.push_back({changed.stem.free_length(), mass});
            }};
}

Change other_pull(const run::CaseSpec& spec, double factor) {
    return {fmt::format("pull the tip aside by {:.1f} mm instead of {:.1f} mm",
                        1e3 * factor * std::abs(spec.tip_deflection),
                        1e3 * std::abs(spec.tip_deflection)),
            [factor](run::CaseSpec& changed) { changed.tip_deflection *= factor; }};
}

Change shorter_stem(const run::CaseSpec& spec) {
    constexpr double share = 0.7;
    return {fmt::format("cut the stem to {:.0f} mm, film the same heights in proportion and "
                        "release again",
                        1e3 * share * spec.stem.free_length()),
            [](run::CaseSpec& changed) {
                const double before = changed.stem.free_length();
                changed.stem.sphere_count = std::max(
                    static_cast<int>(std::lround(share * (changed.stem.sphere_count - 1))) + 1, 5);
                const double ratio = changed.stem.free_length() / before;
                for (double& height : changed.heights)
                    height *= ratio;
                changed.tip_deflection *= ratio;
                changed.sample_interval *= ratio * ratio;
            },
            share * share, 1.0 / (share * share)};
}

/// An experiment that effects declare: each effect that names it changes its values as declared.
Change revealing(const std::string& what) {
    return {what, [what](run::CaseSpec& spec) {
                for (physics::ActiveEffect& active : spec.effects)
                    for (const physics::RevealingExperiment& experiment :
                         active.effect->revealed_by)
                        for (std::size_t k = 0; experiment.what == what && k < active.values.size();
                             ++k)
                            active.values[k] *= experiment.factors.at(k);
            }};
}

/// The first is a repetition of the present experiment.
std::vector<Change> changes_for(const std::pair<Rival, Rival>& pair, const run::CaseSpec& spec) {
    std::vector<physics::EffectPointer> effects;
    for (const Rival* rival : {&pair.first, &pair.second})
        for (const physics::SelectedEffect& selected : rival->fit.effects)
            effects.push_back(selected.effect);
    std::vector<Change> changes{{"release again as before", [](run::CaseSpec&) {}},
                                known_mass(spec, 0.1),
                                known_mass(spec, 0.5),
                                other_pull(spec, 0.3)};
    // Properties along the stem are relative to its length; a shorter stem has another law.
    if (std::ranges::none_of(effects, [](const auto& each) { return each->spans_the_stem; }))
        changes.push_back(shorter_stem(spec));
    if (1.5 * std::abs(spec.tip_deflection) < largest_pull * spec.stem.free_length())
        changes.push_back(other_pull(spec, 1.5));
    changes.push_back({"film with twice the frame rate", [](run::CaseSpec&) {}, 1.0, 2.0});
    changes.push_back({"film twice as long", [](run::CaseSpec&) {}, 2.0, 1.0});
    for (const physics::EffectPointer& effect : effects)
        for (const physics::RevealingExperiment& experiment : effect->revealed_by)
            if (std::ranges::find(changes, experiment.what, &Change::what) == changes.end())
                changes.push_back(revealing(experiment.what));
    return changes;
}

std::vector<double> frames_of(const fit::RecordingFit& fit, const Change& change) {
    const auto count = static_cast<double>(fit.times.size() - 1);
    const double first = fit.times.front();
    const double interval = (fit.times.back() - first) / count / change.rate;
    const double last = first + (fit.times.back() - first) * change.duration;
    std::vector<double> times;
    for (double k = 0.0; first + k * interval <= last * (1.0 + 1e-12); k += 1.0)
        times.push_back(first + k * interval);
    return times;
}

/// Information of this recording about all parameters except those of the release, which are new in
/// each recording, and the errors of the readings. These are eliminated.
/// Shape: (parameters without the errors) twice.
Eigen::MatrixXd information_without_release(const fit::Fit& fit) {
    const fit::WeightedSystem& system = fit.system;
    std::vector<Eigen::Index> kept;
    std::vector<Eigen::Index> others;
    for (std::size_t k = 0; k < system.ids.size(); ++k) {
        const bool is_release = physics::is_of_release(system.ids[k]);
        (is_release || system.errors[k] ? others : kept).push_back(static_cast<Eigen::Index>(k));
    }
    const Eigen::MatrixXd left = fit::Projector(system.jacobian(Eigen::all, others))
                                     .remainder(system.jacobian(Eigen::all, kept));
    const auto size = static_cast<Eigen::Index>(fit.parts.front().model.first_error());
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(size, size);
    out(kept, kept) = left.transpose() * left;
    return out;
}

/// The noise of a recording with `rate` times the frames a second, and how much of the information
/// outliers leave.
struct NextNoise {
    std::shared_ptr<const fit::NoiseModel> model;
    double information = 1.0;
};

NextNoise next_noise(const fit::RecordingFit& fit, double rate) {
    if (!fit.noise_model)
        return {};
    fit::NoiseModel model = *fit.noise_model;
    NextNoise next;
    double weights = 0.0;
    for (const double relative : model.relative)
        weights += 1.0 / (relative * relative);
    if (!model.relative.empty())
        next.information = weights / static_cast<double>(model.relative.size());
    model.relative.clear();
    model.correlation = std::pow(model.correlation, 1.0 / rate);
    next.model = std::make_shared<const fit::NoiseModel>(std::move(model));
    return next;
}

/// The rival's fit; the parameters other than those of an assumed effect are fitted again.
fit::Fit fit_of(const Rival& rival, std::span<const fit::ObservedRecording> alone,
                const fit::FitOptions& options) {
    fit::Fit fit = fit::rerun(rival.fit, alone, options);
    if (rival.assumed.empty())
        return fit;
    fit::JointOptions held{options};
    held.held_effects = {rival.assumed};
    return fit::fit_jointly({&fit.parts.front().model, 1}, alone, std::move(held));
}

/// The smallest squared distance, over the noise, between the prediction of `truth` and that of
/// `other` for any of its parameters.
double gap(const fit::Fit& first_fit, const fit::Fit& second_fit, const Change& change,
           const run::Heartbeat& heartbeat) {
    const fit::RecordingFit& truth = first_fit.parts.front();
    const fit::RecordingFit& other = second_fit.parts.front();
    const std::vector<double> times = frames_of(truth, change);
    fit::StemModel first = truth.model;
    fit::StemModel second = other.model;
    for (fit::StemModel* model : {&first, &second}) {
        model->spec = fit::computed_case(*model);
        model->errors.reset(); // the next recording has its own
        model->error_values.clear();
        change.apply(model->spec);
        model->spec.sample_interval /= change.rate;
    }
    first.parameters.clear(); // only the other's derivatives are needed
    const NextNoise next = next_noise(truth, change.rate);
    fit::ObservedRecording wanted;
    wanted.deflections = fit::predict_readings(first, times, heartbeat).readings;
    wanted.noise_model = next.model;
    const fit::ChainPrediction offered = fit::predict_readings(second, times, heartbeat);
    const std::vector<fit::ErrorTerm> none;
    const fit::SystemPart part{second, wanted, offered, truth.noise, none};
    const fit::WeightedSystem system =
        fit::weighted_system(fit::joint_layout({&second, 1}, {&wanted, 1}), {&part, 1});
    // Least squares of the other model to the first one's prediction, with this recording as prior
    // information: min over θ of |d − J θ|² + θᵀ I θ = |d|² − gᵀ (JᵀJ + I)⁻¹ g, g = Jᵀ d.
    const Eigen::MatrixXd normal = information_without_release(second_fit) +
                                   next.information * system.jacobian.transpose() * system.jacobian;
    const Eigen::VectorXd right = next.information * system.jacobian.transpose() * system.residual;
    return std::max(0.0, next.information * system.residual.squaredNorm() -
                             right.dot(fit::ScaledSpectrum(normal).solve(right).col(0)));
}

} // namespace

std::vector<Experiment> next_experiments(const std::pair<Rival, Rival>& pair,
                                         std::span<const fit::ObservedRecording> recordings,
                                         const fit::FitOptions& options, const core::ItemMap& map) {
    const std::span<const fit::ObservedRecording> alone = recordings.first(1);
    const std::array sides{fit_of(pair.first, alone, options), fit_of(pair.second, alone, options)};
    const std::vector<Change> changes = changes_for(pair, sides.front().parts.front().model.spec);
    const auto work = [&](std::size_t item,
                          const run::Heartbeat& heartbeat) -> std::optional<double> {
        try {
            return gap(sides[0], sides[1], changes[item], heartbeat);
        } catch (const core::NumericalError&) { // that experiment cannot be predicted
            return std::nullopt;
        }
    };
    const auto answers = map.values(std::vector<double>(changes.size(), 1.0), work);
    std::vector<Experiment> experiments;
    for (std::size_t c = 0; c < changes.size(); ++c)
        if (const auto gap = answers[c])
            experiments.push_back(
                {changes[c].what, pair.first.fit.names(), pair.second.fit.names(), *gap});
    // An experiment no better than a repetition of the present one is not proposed.
    const double again = experiments.empty() ? 0.0 : experiments.front().expected_gap;
    std::erase_if(experiments, [again](const Experiment& experiment) {
        return experiment.expected_gap <= worthwhile * again;
    });
    std::ranges::stable_sort(experiments, std::greater{}, &Experiment::expected_gap);
    experiments.resize(std::min(experiments.size(), most_experiments));
    return experiments;
}

} // namespace culm::diagnose
