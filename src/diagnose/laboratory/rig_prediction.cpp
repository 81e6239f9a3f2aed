// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/laboratory/rig_prediction.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

namespace culm::diagnose {
namespace {

/// Have two stems the same points of the grid, with columns for the same sizes?
bool has_same_columns(const EffectColumns& one, const EffectColumns& other) {
    return std::ranges::equal(one.nodes, other.nodes, [](const auto& a, const auto& b) {
        return std::ranges::equal(a.columns, b.columns, [](const auto& left, const auto& right) {
            return left.parameter == right.parameter && left.is_certain == right.is_certain &&
                   (left.secant == 0.0) == (right.secant == 0.0);
        });
    });
}

} // namespace

RigPrediction::RigPrediction(const LaboratoryStems& stems, std::span<const StemSurvey> surveys,
                             const LaboratoryModel& model, std::string rig)
    : stems_(stems), rig_(std::move(rig)), linear_({}, {}, {}) {
    for (std::size_t s = 0; s < surveys.size(); ++s)
        if (stems.specimens[s].rig == rig_ && !surveys[s].rig_columns.empty())
            on_rig_.push_back(s);
    for (std::size_t c = 0; c < stems.options.candidates.size(); ++c)
        average(c, surveys);
    linear_ = sum(surveys, model.shared);
}

/// Structure of the first stem that shows the candidate, with the stems' means of the values at its
/// points and of the usual sizes.
void RigPrediction::average(std::size_t candidate, std::span<const StemSurvey> surveys) {
    EffectColumns& common = columns_.emplace_back();
    std::vector<ParameterPrior>& priors = priors_.emplace_back();
    common.failure = "no stem shows it";
    double count = 0.0;
    for (const std::size_t s : on_rig_) {
        const EffectColumns& mine = surveys[s].rig_columns[candidate];
        if (!mine.failure.empty() || (count > 0.0 && !has_same_columns(common, mine)))
            continue;
        if (count == 0.0) {
            common = mine;
            priors = surveys[s].priors[candidate];
        } else {
            for (std::size_t k = 0; k < priors.size(); ++k) {
                priors[k].deviation += surveys[s].priors[candidate][k].deviation;
                for (std::size_t n = 0; n < common.nodes.size(); ++n)
                    common.nodes[n].values[k] += mine.nodes[n].values[k];
            }
        }
        count += 1.0;
    }
    for (ParameterPrior& prior : priors)
        prior.deviation /= count;
    for (EffectNode& node : common.nodes)
        for (double& value : node.values)
            value /= count;
}

/// Where the columns of one stem are in the sum, and what converts them to the common units.
struct RigPrediction::Placement {
    std::vector<Eigen::Index> from;
    std::vector<Eigen::Index> to;
    std::vector<double> factors;

    void add(Eigen::Index own, Eigen::Index common, double factor) {
        from.push_back(own);
        to.push_back(common);
        factors.push_back(factor);
    }
};

/// Of the candidates' columns.
RigPrediction::Placement RigPrediction::placement_of(const StemSurvey& survey) const {
    Placement place;
    Eigen::Index own = 0;
    Eigen::Index common = 0;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
        const EffectColumns& mine = survey.rig_columns[c];
        const bool is_same = mine.failure.empty() && has_same_columns(columns_[c], mine);
        Eigen::Index at = common;
        for (const EffectNode& node : mine.nodes)
            for (const EffectColumn& column : node.columns) {
                const bool has_size = column.parameter < priors_[c].size();
                if (is_same)
                    place.add(own, at++,
                              has_size ? priors_[c][column.parameter].deviation /
                                             survey.priors[c][column.parameter].deviation
                                       : 1.0);
                ++own;
            }
        common += columns_[c].column_count();
    }
    return place;
}

/// Sum of the stems' SᵀS and Sᵀr, without what the shared numbers imitate.
LinearEvidence RigPrediction::sum(std::span<const StemSurvey> surveys,
                                  const SharedMinimum& shared) const {
    Eigen::Index columns = 0;
    for (const EffectColumns& each : columns_)
        columns += each.column_count();
    const auto shared_count = static_cast<Eigen::Index>(shared.names.size());
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(columns + shared_count, columns + shared_count);
    Eigen::VectorXd overlap = Eigen::VectorXd::Zero(columns + shared_count);
    for (const std::size_t s : on_rig_) {
        const StemSurvey& survey = surveys[s];
        Placement place = placement_of(survey);
        const auto size = static_cast<Eigen::Index>(survey.overlap.size());
        const Eigen::Map<const Eigen::MatrixXd> own_gram(survey.gram.data(), size, size);
        // The residual at the common values of the shared numbers.
        Eigen::VectorXd here = Eigen::Map<const Eigen::VectorXd>(survey.overlap.data(), size);
        for (std::size_t k = 0; k < survey.shared.size(); ++k) {
            const Eigen::Index own =
                size - std::ssize(survey.shared) + static_cast<Eigen::Index>(k);
            const Eigen::Index at = shared.find(survey.shared[k]);
            here -= own_gram.col(own) * (shared.at(at) - survey.shared_at[k]);
            place.add(own, columns + at, 1.0);
        }
        const Eigen::Map<const Eigen::VectorXd> factor(
            place.factors.data(), static_cast<Eigen::Index>(place.factors.size()));
        gram(place.to, place.to) +=
            factor.asDiagonal() * own_gram(place.from, place.from) * factor.asDiagonal();
        overlap(place.to) += factor.asDiagonal() * here(place.from);
    }
    Eigen::MatrixXd seen = gram.topLeftCorner(columns, columns);
    if (shared_count > 0) {
        const Eigen::VectorXd scale = shared.hessian.diagonal().cwiseSqrt().cwiseInverse();
        const Eigen::LDLT<Eigen::MatrixXd> factors(scale.asDiagonal() * shared.hessian *
                                                   scale.asDiagonal());
        const Eigen::MatrixXd across =
            scale.asDiagonal() * gram.bottomLeftCorner(shared_count, columns);
        seen -= across.transpose() * factors.solve(across);
    }
    return {columns_, std::move(seen), overlap.head(columns)};
}

RigEffect RigPrediction::estimated(std::size_t candidate, std::size_t place,
                                   const PredictedGain& gain) const {
    const PlacedEffect& estimate = gain.points.front().effects[place];
    const EffectNode& node = columns_[candidate].nodes[estimate.nearest()];
    RigEffect out = stems_.with_default_values(stems_.options.candidates[candidate], rig_, false);
    const std::vector<physics::EffectParameter> parameters = out.effect.effect->parameters();
    const std::vector<std::size_t> places = free_parameters(out.effect);
    for (std::size_t free = 0; free < places.size(); ++free) {
        const std::size_t k = places[free];
        out.values[k] = node.values[free];
        const ParameterPrior& prior = priors_[candidate][free];
        for (std::size_t c = 0; c < node.columns.size() && !prior.is_place; ++c)
            if (node.columns[c].parameter == free) {
                const double value = fit::from_coordinate(
                    parameters[k].fitted_as, prior.absent + estimate.amounts[c] * prior.deviation);
                out.values[k] = std::isfinite(value) // a stiffness without compliance is not
                                    ? std::clamp(value, parameters[k].lower, parameters[k].upper)
                                    : parameters[k].upper;
            }
    }
    return out;
}

} // namespace culm::diagnose
