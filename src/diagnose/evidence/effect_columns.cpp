// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/evidence/effect_columns.hpp"

#include "core/error.hpp"
#include "core/lanes.hpp"
#include "diagnose/evidence/log_evidence.hpp"
#include "fit/chain/superposition.hpp"
#include "fit/solve/error_solution.hpp"
#include "fit/start/starts.hpp"
#include "run/case_model.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

namespace culm::diagnose {
namespace {

/// In standard deviations of the prior: a swing of N cycles is linear in a change of its frequency
/// up to 1/N of it, and the runs have rounding errors of 1e-10.
constexpr double small_change = 1e-5;
/// Change of Y that keeps the first mode, above which the location alone changes the model.
constexpr double least_offset = 1e-6;
/// Largest grid of locations for which secants are computed in addition to derivatives.
constexpr std::size_t most_secants = 3;

class ColumnsOfEffect {
  public:
    ColumnsOfEffect(const fit::Fit& base, const physics::SelectedEffect& effect,
                    std::span<const fit::ObservedRecording> recordings,
                    const fit::FitOptions& options)
        : base_(base), effect_(effect), recordings_(recordings), options_(options) {
        for (std::size_t m = 0; m < recordings.size(); ++m)
            models_.push_back(candidate_model(base.parts[m].model, {effect}, recordings[m]));
        // The recording in which the effect acts.
        while (first_ + 1 < models_.size() &&
               models_[first_].spec.effects.size() == base.parts[first_].model.spec.effects.size())
            ++first_;
        for (const fit::FreeParameter& parameter : models_[first_].parameters)
            if (parameter.access.id.effect == effect.effect->name)
                own_.push_back(parameter);
        is_seen_as_planar_ = run::dimensions_of(base.parts[first_].model.spec) == 2 &&
                             !fit::planar_models(models_[first_]).empty();
    }

    [[nodiscard]] EffectColumns compute() {
        EffectColumns out;
        if (own_.empty()) {
            EffectNode node;
            node.columns.push_back({read({models_}).front() - base_.system.predicted});
            node.columns.back().is_certain = true;
            out.nodes.push_back(std::move(node));
            out.batches = batches_;
            return out;
        }
        const std::vector<fit::StemModel> absent =
            fit_starts(models_[first_], base_.parts[first_], fit::StartSize::Absent);
        std::vector<Group> groups;
        // Its derivative where it is absent is that of Y.
        for (std::size_t k = 0; !is_seen_as_planar_ && k < absent.size(); ++k)
            groups.push_back(derivatives_at(node_at(absent[k])));
        if (absent.size() <= most_secants || has_own_sizes(models_[first_], base_.parts[first_]))
            for (const fit::StemModel& start :
                 fit_starts(models_[first_], base_.parts[first_], fit::StartSize::Default))
                if (std::optional<Group> group = secant_to(node_at(start)))
                    groups.push_back(*std::move(group));
        compute(groups);
        for (Group& group : groups)
            if (!group.readings.empty())
                out.nodes.push_back(finished(std::move(group)));
        out.batches = batches_;
        if (out.nodes.empty())
            out.failure = failure_.empty() ? "no run shows what it does" : failure_;
        return out;
    }

  private:
    [[nodiscard]] EffectNode node_at(const fit::StemModel& start) const {
        EffectNode node;
        for (const fit::FreeParameter& parameter : own_)
            node.values.push_back(parameter.access.get(start.spec));
        const physics::StemParameters<double>& stem = base_.parts[first_].model.spec.stem;
        node.modulus_ratio = start.spec.stem.bond_youngs_modulus / stem.bond_youngs_modulus;
        node.damping_ratio = start.spec.stem.bond_damping / stem.bond_damping;
        return node;
    }

    /// The models of the recordings at the node.
    [[nodiscard]] fit::StartModels models_at(const EffectNode& node) const {
        fit::StartModels models = models_;
        for (fit::StemModel& model : models) {
            model.spec.stem.bond_youngs_modulus *= node.modulus_ratio;
            model.spec.stem.bond_damping *= node.damping_ratio;
            for (const fit::FreeParameter& parameter : model.parameters)
                for (std::size_t k = 0; k < own_.size(); ++k)
                    if (parameter.access.id == own_[k].access.id)
                        parameter.access.set(model.spec, node.values[k]);
        }
        return models;
    }

    /// One point of the grid: the runs that it needs, and their results.
    struct Group {
        EffectNode node;
        std::vector<std::size_t> sizes;     ///< parameters
        std::vector<ParameterPrior> priors; ///< (sizes)
        double secant = 0.0; ///< size at the node over the prior's deviation; 0: derivatives
        std::vector<fit::StartModels> runs;    ///< of derivatives: the node, then each size changed
        std::vector<Eigen::VectorXd> readings; ///< (runs); empty: could not be computed
    };

    [[nodiscard]] std::vector<Eigen::VectorXd> read(const std::vector<fit::StartModels>& runs) {
        return fit::readings_together(runs, base_, recordings_, options_.heartbeat, batches_);
    }

    /// Fills the lanes with groups; if one group fails, each of them is computed separately.
    void compute(std::vector<Group>& groups) {
        for (std::size_t begin = 0; begin < groups.size();) {
            std::size_t end = begin;
            std::vector<fit::StartModels> runs;
            while (end < groups.size() &&
                   (end == begin || runs.size() + groups[end].runs.size() <= core::lane_count)) {
                runs.insert(runs.end(), groups[end].runs.begin(), groups[end].runs.end());
                ++end;
            }
            if (!try_groups({&groups[begin], end - begin}, runs) && end > begin + 1)
                for (std::size_t k = begin; k < end; ++k)
                    try_groups({&groups[k], 1}, groups[k].runs);
            begin = end;
        }
    }

    bool try_groups(std::span<Group> groups, const std::vector<fit::StartModels>& runs) {
        try {
            std::vector<Eigen::VectorXd> readings = read(runs);
            auto next = readings.begin();
            for (Group& group : groups)
                for (std::size_t k = 0; k < group.runs.size(); ++k)
                    group.readings.push_back(std::move(*next++));
            return true;
        } catch (const core::NumericalError& error) {
            failure_ = error.what();
            return false;
        }
    }

    /// Changes of the readings by each size from the node on.
    [[nodiscard]] Group derivatives_at(EffectNode node) const {
        Group group;
        group.node = std::move(node);
        group.runs.push_back(models_at(group.node));
        for (std::size_t k = 0; k < own_.size(); ++k) {
            if (own_[k].is_place)
                continue;
            group.sizes.push_back(k);
            group.priors.push_back(prior_of(own_[k], group.runs.front()[first_]));
            fit::StartModels& changed = group.runs.emplace_back(group.runs.front());
            for (fit::StemModel& model : changed)
                model =
                    moved(std::move(model), own_[k], small_change * group.priors.back().deviation);
        }
        return group;
    }

    /// The secant from the model without the effect to its usual size, along the size that is
    /// largest relative to its usual value; none if the effect has no size there.
    [[nodiscard]] std::optional<Group> secant_to(EffectNode node) const {
        if (recordings_.size() > 1) {
            node.modulus_ratio = 1.0; // one material cannot keep the first mode of each
            node.damping_ratio = 1.0;
        }
        Group group;
        group.node = std::move(node);
        group.runs.push_back(models_at(group.node));
        group.sizes.push_back(0);
        group.priors.emplace_back();
        for (std::size_t k = 0; k < own_.size(); ++k) {
            if (own_[k].is_place)
                continue;
            const ParameterPrior prior = prior_of(own_[k], group.runs.front()[first_]);
            const double size =
                (fit::to_coordinate(own_[k].fitted_as, group.node.values[k]) - prior.absent) /
                prior.deviation;
            if (std::abs(size) <= std::abs(group.secant))
                continue;
            group.secant = size;
            group.sizes.front() = k;
            group.priors.front() = prior;
        }
        if (group.secant == 0.0)
            return std::nullopt;
        return group;
    }

    [[nodiscard]] EffectNode finished(Group group) const {
        EffectNode node = std::move(group.node);
        const Eigen::VectorXd& here = group.readings.front();
        if (group.secant != 0.0) {
            EffectColumn column{1.0 / group.secant * (here - base_.system.predicted)};
            column.parameter = group.sizes.front();
            set_prior(group.priors.front(), column);
            column.secant = group.secant;
            node.columns.push_back(std::move(column));
            return node;
        }
        if (std::abs(node.modulus_ratio - 1.0) > least_offset) {
            EffectColumn column{here - base_.system.predicted};
            column.is_one_sided = true;
            node.columns.push_back(std::move(column));
        }
        for (std::size_t s = 0; s < group.sizes.size(); ++s)
            add_derivative(group.readings[s + 1], here, group.sizes[s], group.priors[s], node);
        return node;
    }

    static void set_prior(const ParameterPrior& prior, EffectColumn& column) {
        column.is_one_sided = prior.is_one_sided;
        column.absent = prior.absent;
        column.deviation = prior.deviation;
        if (prior.known_within > 0.0) {
            column.known_amount = (prior.known - prior.absent) / prior.deviation;
            column.known_precision = std::pow(prior.deviation / prior.known_within, 2);
        }
    }

    /// The column of a size, or one column per recording if recordings have separate sizes.
    void add_derivative(const Eigen::VectorXd& changed, const Eigen::VectorXd& from,
                        std::size_t parameter, const ParameterPrior& prior,
                        EffectNode& node) const {
        EffectColumn column{1.0 / small_change * (changed - from)};
        column.parameter = parameter;
        set_prior(prior, column);
        if (!fit::belongs_to_recording(own_.front().access.id) || recordings_.size() == 1) {
            node.columns.push_back(std::move(column));
            return;
        }
        Eigen::Index begin = 0;
        for (const fit::RecordingFit& part : base_.parts) {
            Eigen::VectorXd& own = node.columns.emplace_back(column).readings;
            own.head(begin).setZero();
            begin += std::ssize(part.residuals);
            own.tail(own.size() - begin).setZero();
        }
    }

    /// The model with one of the effect's numbers changed; the same where the effect does not act.
    [[nodiscard]] static fit::StemModel moved(fit::StemModel model,
                                              const fit::FreeParameter& parameter, double change) {
        if (std::ranges::none_of(model.spec.effects, [&](const physics::ActiveEffect& active) {
                return active.effect->name == parameter.access.id.effect;
            }))
            return model;
        const double value = parameter.access.get(model.spec);
        parameter.access.set(
            model.spec,
            fit::from_coordinate(parameter.fitted_as,
                                 fit::to_coordinate(parameter.fitted_as, value) + change));
        return model;
    }

    const fit::Fit& base_;
    const physics::SelectedEffect& effect_;
    std::span<const fit::ObservedRecording> recordings_;
    const fit::FitOptions& options_;
    bool is_seen_as_planar_ = false; ///< the effect, which leaves the plane
    fit::StartModels models_;
    std::size_t first_ = 0;
    std::vector<fit::FreeParameter> own_;
    std::string failure_;
    int batches_ = 0;
};

} // namespace

Eigen::Index EffectColumns::column_count() const {
    Eigen::Index count = 0;
    for (const EffectNode& node : nodes)
        count += static_cast<Eigen::Index>(node.columns.size());
    return count;
}

EffectColumns effect_columns(const fit::Fit& base, const physics::SelectedEffect& effect,
                             std::span<const fit::ObservedRecording> recordings,
                             const fit::FitOptions& options) {
    EffectColumns failed;
    try {
        return ColumnsOfEffect(base, effect, recordings, options).compute();
    } catch (const std::runtime_error& error) { // InputError or NumericalError
        failed.failure = error.what();
    }
    return failed;
}

} // namespace culm::diagnose
