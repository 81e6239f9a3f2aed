// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/moved_inputs.hpp"

#include "core/error.hpp"
#include "fit/errors/stated_inputs.hpp"

#include <array>
#include <cmath>
#include <tuple>
#include <utility>

namespace culm::fit {
namespace {

constexpr std::array tried_shares{1.0, 0.5, 0.25, 0.1}; ///< of a change, one in each lane
constexpr double small_shortfall = 1.0; ///< of χ², from what the solution promises

class InputTrials {
  public:
    InputTrials(std::span<const ObservedRecording> recordings, const JointLayout& layout,
                const run::Heartbeat& heartbeat, Fit& fit)
        : recordings_(recordings), layout_(layout), heartbeat_(heartbeat), fit_(fit) {
        for (std::size_t m = 0; m < fit.parts.size(); ++m) {
            inputs_.push_back(stated_inputs(recordings[m]));
            if (fit.parts[m].terms.size() < inputs_.back().size())
                inputs_.back().clear(); // the fit has no terms of inputs
            terms_.push_back(fit.parts[m].terms);
        }
    }

    [[nodiscard]] bool contradicts(const Eigen::VectorXd& change) const {
        for (std::size_t m = 0; m < inputs_.size(); ++m)
            for (std::size_t k = 0; k < inputs_[m].size(); ++k)
                if (inputs_[m][k].acts == InputActs::OnChain &&
                    std::abs(change(column_of(m, k))) > contradiction)
                    return true;
        return false;
    }

    [[nodiscard]] MovedInputs at_fit() const {
        MovedInputs out{start_from(fit_),
                        Eigen::VectorXd::Zero(fit_.system.jacobian.cols()),
                        fit_.system.residual,
                        {}};
        for (const RecordingFit& part : fit_.parts)
            out.readings.push_back(part.prediction.readings);
        return out;
    }

    /// The best point on a straight change from `from`, which may be `from` itself.
    [[nodiscard]] MovedInputs best_of(const MovedInputs& from, const Eigen::VectorXd& change) {
        std::vector<StartModels> runs;
        for (const double share : tried_shares)
            runs.push_back(models_at(from, change, share));
        auto predictions = predict_runs(runs, times_of(fit_), heartbeat_, fit_.batches);
        MovedInputs best = from;
        for (std::size_t k = 0; k < runs.size(); ++k) {
            MovedInputs point{std::move(runs[k]), from.change + tried_shares[k] * change, {}, {}};
            point.left = system_of(point, std::move(predictions[k])).residual;
            if (point.left.squaredNorm() < best.left.squaredNorm())
                best = std::move(point);
        }
        return best;
    }

    /// The system about a point, with new derivatives. They change what remains there, because an
    /// error of the scale is proportional to the motion.
    [[nodiscard]] WeightedSystem system_about(MovedInputs& point) {
        std::vector<ChainPrediction> predictions;
        for (std::size_t m = 0; m < fit_.parts.size(); ++m) {
            RecordingFit part;
            part.times = fit_.parts[m].times;
            part.model = point.models[m];
            part.prediction = predict_readings(part.model, part.times, heartbeat_);
            fit_.batches += part.prediction.batches;
            measure::Measurement changed = recordings_[m];
            std::tie(changed.stem, changed.heights) =
                restated(recordings_[m], inputs_[m], errors_of(m, point.change));
            std::vector<ErrorTerm> now = input_terms(part, changed, heartbeat_, fit_.batches);
            for (std::size_t k = 0; k < now.size(); ++k)
                terms_[m][k].readings = std::move(now[k].readings);
            predictions.push_back(std::move(part.prediction));
        }
        WeightedSystem system = system_of(point, std::move(predictions));
        point.left = system.residual;
        return system;
    }

  private:
    [[nodiscard]] Eigen::Index column_of(std::size_t m, std::size_t term) const {
        return fit_.system.column_of(fit_.parts[m].terms[term]);
    }

    [[nodiscard]] std::vector<double> errors_of(std::size_t m,
                                                const Eigen::VectorXd& change) const {
        std::vector<double> errors;
        for (std::size_t k = 0; k < inputs_[m].size(); ++k)
            errors.push_back(change(column_of(m, k)));
        return errors;
    }

    [[nodiscard]] StartModels models_at(const MovedInputs& from, const Eigen::VectorXd& change,
                                        double share) const {
        const auto count = static_cast<Eigen::Index>(layout_.ids.size());
        return in_valley(
            [&](double part) {
                StartModels models = moved(from.models, layout_, part * share * change.head(count));
                const Eigen::VectorXd total = from.change + part * share * change;
                for (std::size_t m = 0; m < models.size(); ++m) {
                    const auto [stem, heights] =
                        restated(recordings_[m], inputs_[m], errors_of(m, total));
                    set_stem(stem, models[m].spec);
                    models[m].spec.heights = heights;
                }
                return models;
            },
            layout_);
    }

    /// The system at a point from `predictions` that have the moved geometry; its readings are set.
    [[nodiscard]] WeightedSystem system_of(MovedInputs& point,
                                           std::vector<ChainPrediction> predictions) const {
        point.readings.clear();
        std::vector<SystemPart> parts;
        for (std::size_t m = 0; m < fit_.parts.size(); ++m) {
            add_other_terms(m, point.change, predictions[m]);
            point.readings.push_back(predictions[m].readings);
            parts.push_back(
                {point.models[m], recordings_[m], predictions[m], fit_.parts[m].noise, terms_[m]});
        }
        WeightedSystem system = weighted_system(layout_, parts);
        const Eigen::Index count = point.change.size() - std::ssize(layout_.ids);
        system.residual.tail(count) = -point.change.tail(count);
        return system;
    }

    /// Adds what does not act on the geometry.
    void add_other_terms(std::size_t m, const Eigen::VectorXd& change,
                         ChainPrediction& prediction) const {
        std::vector<double> scales(prediction.rows, 1.0);
        Eigen::VectorXd added = Eigen::VectorXd::Zero(std::ssize(prediction.readings));
        for (std::size_t k = 0; k < terms_[m].size(); ++k) {
            const double amount = change(column_of(m, k));
            const StatedInput* input = k < inputs_[m].size() ? &inputs_[m][k] : nullptr;
            if (input != nullptr && input->acts != InputActs::OnClock) {
                for (std::size_t j = 0; j < scales.size(); ++j)
                    if (input->acts == InputActs::OnPicture ||
                        (input->acts == InputActs::OnSensor && input->row == j))
                        scales[j] -= amount * input->standard_uncertainty;
            } else if (!terms_[m][k].readings.empty()) {
                added += amount * Eigen::Map<const Eigen::VectorXd>(terms_[m][k].readings.data(),
                                                                    added.size());
            }
        }
        for (std::size_t at = 0; at < prediction.readings.size(); ++at) {
            double& reading = prediction.readings[at];
            reading = scales[at % prediction.rows] * reading + added(static_cast<Eigen::Index>(at));
            if (!std::isfinite(
                    reading)) // a row beyond the end of a shorter stem keeps its residual
                reading = fit_.parts[m].prediction.readings[at];
        }
    }

    std::span<const ObservedRecording> recordings_;
    const JointLayout& layout_;
    const run::Heartbeat& heartbeat_;
    Fit& fit_;
    std::vector<std::vector<StatedInput>> inputs_; ///< (recordings) of the first terms
    std::vector<std::vector<ErrorTerm>> terms_;    ///< (recordings) about the last system
};

} // namespace

std::optional<MovedInputs> moved_inputs(std::span<const ObservedRecording> recordings,
                                        const JointLayout& layout, const Eigen::VectorXd& change,
                                        const LinearSolver& solve, int most_passes,
                                        const run::Heartbeat& heartbeat, Fit& fit) {
    InputTrials trials(recordings, layout, heartbeat, fit);
    if (!trials.contradicts(change))
        return std::nullopt;
    MovedInputs best = trials.at_fit();
    try {
        double promised = (fit.system.residual - fit.system.jacobian * change).squaredNorm();
        best = trials.best_of(best, change);
        for (int pass = 0; pass < most_passes; ++pass) {
            if (best.left.squaredNorm() < promised + small_shortfall)
                break;
            const WeightedSystem about = trials.system_about(best);
            const Eigen::VectorXd further = solve(about, best.models, best.change);
            promised = (about.residual - about.jacobian * further).squaredNorm();
            best = trials.best_of(best, further);
        }
    } catch (const core::NumericalError&) { // no chain has inputs so far away
    }
    return best;
}

} // namespace culm::fit
