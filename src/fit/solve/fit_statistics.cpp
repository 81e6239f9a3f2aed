// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/layout.hpp"
#include "fit/solve/reading_errors.hpp"
#include "fit/solve/residual_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <string>

#include <Eigen/Core>
#include <fmt/core.h>

namespace culm::fit {

namespace {

/// A parameter is at a bound within this share of its range or (logarithmic) of its value.
constexpr double nearness = 1e-6;

/// Adds the residuals and returns their sum of squares.
double add_residuals(const ObservedRecording& measurement, RecordingFit& fit) {
    const std::size_t rows = fit.prediction.rows;
    fit.residuals.resize(fit.times.size() * rows);
    double sum_of_squares = 0.0;
    for (std::size_t i = 0; i < fit.times.size(); ++i)
        for (std::size_t j = 0; j < rows; ++j) {
            double& residual = fit.residuals[i * rows + j];
            residual = measurement.deflection(i, j) - fit.prediction.readings[i * rows + j];
            if (std::isnan(residual))
                continue;
            ++fit.readings;
            sum_of_squares += residual * residual;
        }
    fit.chi_squared = whitened_residuals(fit).squaredNorm();
    if (fit.readings > 0)
        fit.rmse = std::sqrt(sum_of_squares / static_cast<double>(fit.readings));
    return sum_of_squares;
}

/// Inverse of a symmetric matrix that may be singular.
struct InverseInformation {
    Eigen::MatrixXd inverse; ///< without the directions that have no information
    /// A parameter with more than a thousandth of its length in such a direction has an unbounded
    /// variance.
    std::vector<bool> is_unknown;
};

InverseInformation inverse_information(const Eigen::MatrixXd& matrix) {
    const InformationDirections told = information_directions(matrix);
    const Eigen::Index count = matrix.rows();
    Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(count, count);
    Eigen::VectorXd unknown = Eigen::VectorXd::Zero(count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const Eigen::VectorXd direction = told.directions.col(k);
        if (told.is_known(k))
            inverse += direction * direction.transpose() / told.information(k);
        else
            unknown += direction.cwiseAbs2();
    }
    InverseInformation out{told.scale.cwiseInverse().asDiagonal() * inverse *
                               told.scale.cwiseInverse().asDiagonal(),
                           {}};
    for (const double share : unknown)
        out.is_unknown.push_back(share > 1e-6);
    return out;
}

/// Covariance, with an infinite variance of every parameter that is_unknown.
Eigen::MatrixXd covariance_of(const InverseInformation& information) {
    Eigen::MatrixXd covariance = information.inverse;
    for (std::size_t k = 0; k < information.is_unknown.size(); ++k)
        if (const auto at = static_cast<Eigen::Index>(k); information.is_unknown[k])
            covariance(at, at) = std::numeric_limits<double>::infinity();
    return covariance;
}

bool is_error(const JointLayout& layout, const Fit& fit, std::size_t joint) {
    const auto [model, parameter] = layout.owners[joint];
    return fit.parts[model].model.is_error(parameter);
}

/// Jᵀ W J of all parts over the readings that were seen, by the joint parameters.
Eigen::MatrixXd joint_information(const JointLayout& layout, const Fit& fit) {
    const auto count = static_cast<Eigen::Index>(layout.ids.size());
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count);
    for (std::size_t m = 0; m < fit.parts.size(); ++m) {
        const Eigen::MatrixXd jacobian = whitened_jacobian(fit.parts[m]);
        const Eigen::MatrixXd own = jacobian.transpose() * jacobian;
        const std::vector<JointLayout::Share>& shares = layout.shares[m];
        for (std::size_t a = 0; a < shares.size(); ++a)
            for (std::size_t b = 0; b < shares.size(); ++b)
                sum(static_cast<Eigen::Index>(shares[a].place),
                    static_cast<Eigen::Index>(shares[b].place)) +=
                    shares[a].factor * shares[b].factor *
                    own(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
    }
    return sum;
}

/// Covariance of the parameters that are not held; rows and columns of the others are 0.
void add_covariance(const JointLayout& layout, const std::vector<bool>& is_held, Fit& fit) {
    const auto count = static_cast<Eigen::Index>(layout.ids.size());
    std::vector<Eigen::Index> free;
    for (Eigen::Index k = 0; k < count; ++k)
        if (!is_held[static_cast<std::size_t>(k)])
            free.push_back(k);
    fit.covariance = Eigen::MatrixXd::Zero(count, count);
    if (free.empty())
        return;
    Eigen::MatrixXd all = joint_information(layout, fit);
    // A misfit above the noise makes the errors larger; a χ² below 1 does not make them smaller
    // than the stated noise allows. Constraints are not readings and keep their weight.
    all /= std::max(1.0, fit.reduced_chi_squared);
    for (Eigen::Index k = 0; k < count; ++k)
        if (is_error(layout, fit, static_cast<std::size_t>(k)))
            all(k, k) += 1.0;
    fit.covariance(free, free) = covariance_of(inverse_information(all(free, free)));
}

/// The joint covariance restricted to one part, in the part's own values.
void add_covariance(const std::vector<JointLayout::Share>& shares,
                    const Eigen::MatrixXd& covariance, RecordingFit& part) {
    const auto count = static_cast<Eigen::Index>(shares.size());
    part.covariance.resize(count, count);
    part.correlation = Eigen::MatrixXd::Identity(count, count);
    const auto share = [&](Eigen::Index k) { return shares[static_cast<std::size_t>(k)]; };
    for (Eigen::Index a = 0; a < count; ++a)
        for (Eigen::Index b = 0; b < count; ++b)
            part.covariance(a, b) = share(a).factor * share(b).factor *
                                    covariance(static_cast<Eigen::Index>(share(a).place),
                                               static_cast<Eigen::Index>(share(b).place));
    for (Eigen::Index a = 0; a < count; ++a)
        for (Eigen::Index b = 0; b < count; ++b) {
            const double scale = std::sqrt(part.covariance(a, a) * part.covariance(b, b));
            if (a != b)
                part.correlation(a, b) = scale > 0.0 ? part.covariance(a, b) / scale : 0.0;
        }
}

bool is_near(const FreeParameter& parameter, double value, double bound) {
    switch (parameter.fitted_as) {
    case physics::FittedAs::Logarithm:
        return std::abs(std::log(value / bound)) < nearness;
    case physics::FittedAs::Inverse:
        return std::abs(1.0 / value - 1.0 / bound) < nearness / parameter.lower;
    case physics::FittedAs::Itself:
        break;
    }
    return std::abs(value - bound) < nearness * (parameter.upper - parameter.lower);
}

void add_standard_errors(RecordingFit& part) {
    for (std::size_t k = 0; k < part.parameters.size(); ++k) {
        const auto place = static_cast<Eigen::Index>(k);
        part.parameters[k].standard_error = std::sqrt(part.covariance(place, place));
    }
}

void add_parameters(RecordingFit& fit) {
    for (const FreeParameter& parameter : fit.model.parameters) {
        const double value = parameter.access.get(fit.model.spec);
        const bool at_bound = is_near(parameter, value, parameter.lower) ||
                              is_near(parameter, value, parameter.upper);
        fit.parameters.push_back({parameter.access.id, parameter.unit, value, 0.0, at_bound,
                                  parameter.lower, parameter.upper, parameter.fitted_as,
                                  parameter.is_place, parameter.absent});
    }
    if (const double bound = fit.model.release_time_bound; bound > 0.0) {
        const double expected = fit.model.expected_release;
        fit.parameters.push_back(
            {physics::release_time, "s", fit.model.release_time, 0.0,
             bound - std::abs(fit.model.release_time - expected) < nearness * bound,
             expected - bound, expected + bound});
    }
    const std::vector<physics::ParameterId> ids = fit.model.free_ids();
    for (std::size_t k = fit.model.first_error(); k < ids.size(); ++k) {
        FittedParameter& error = fit.parameters.emplace_back();
        error.id = ids[k];
        error.value = fit.model.value(k);
        error.lower = -std::numeric_limits<double>::infinity();
        error.upper = std::numeric_limits<double>::infinity();
        error.is_error = true;
    }
    add_standard_errors(fit);
}

void say_bounds(const std::vector<FittedParameter>& parameters, const std::vector<bool>& is_held,
                std::string& reason) {
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (const FittedParameter& parameter = parameters[k]; parameter.is_at_bound && !is_held[k])
            reason += fmt::format("{}{} is at its bound, {:.6g}{}{}{}", reason.empty() ? "" : "; ",
                                  to_string(parameter.id), parameter.value,
                                  parameter.unit.empty() ? "" : " ", parameter.unit,
                                  parameter.id.in_one_model() == physics::release_time
                                      ? " (time 0 is not the release: state its uncertainty, "
                                        "[release] time_uncertainty_ms, or let the fit begin later "
                                        "with kind = \"moving\" and start_s)"
                                      : "");
}

/// Sets degrees of freedom and χ², and before them the noise if only the residuals determine it.
void add_chi_squared(std::size_t free, RecordingFit& part) {
    part.degrees_of_freedom = part.readings > free ? part.readings - free : 0;
    const auto degrees = static_cast<double>(std::max<std::size_t>(part.degrees_of_freedom, 1));
    if (!part.is_noise_known) {
        const double factor = std::sqrt(part.chi_squared / degrees);
        for (double& noise : part.noise)
            noise *= factor;
        part.chi_squared = degrees;
    }
    part.reduced_chi_squared = part.chi_squared / degrees;
}

std::vector<bool> held_of(const std::vector<JointLayout::Share>& shares,
                          const std::vector<bool>& is_held) {
    std::vector<bool> own;
    own.reserve(shares.size());
    for (const JointLayout::Share& share : shares)
        own.push_back(is_held[share.place]);
    return own;
}

/// Number of fitted parameters. An error term adds a residual and so takes no degree of freedom.
std::size_t free_count(const std::vector<bool>& is_held) {
    return static_cast<std::size_t>(std::ranges::count(is_held, false));
}

/// Sums over the parts, whose residuals are known.
void add_sums(const JointLayout& layout, std::vector<bool> is_held, double sum_of_squares,
              Fit& fit) {
    for (std::size_t k = 0; k < is_held.size(); ++k)
        if (is_error(layout, fit, k)) { // adds its square to the first part that has it
            const auto [model, parameter] = layout.owners[k];
            fit.parts[model].chi_squared += std::pow(fit.parts[model].model.value(parameter), 2);
            is_held[k] = true;
        }
    double weighted = 0.0;
    for (std::size_t m = 0; m < fit.parts.size(); ++m) {
        RecordingFit& part = fit.parts[m];
        fit.readings += part.readings;
        fit.noise.push_back(part.noise);
        weighted += part.chi_squared;
        add_chi_squared(free_count(held_of(layout.shares[m], is_held)), part);
        fit.chi_squared += part.chi_squared;
        fit.misfits.push_back({part.readings, part.chi_squared, part.rmse, part.is_noise_known});
    }
    const auto readings = static_cast<double>(std::max<std::size_t>(fit.readings, 1));
    fit.rmse = std::sqrt(sum_of_squares / readings);
    fit.weighted_rms = std::sqrt(weighted / readings);
    const std::size_t free = free_count(is_held);
    fit.degrees_of_freedom = fit.readings > free ? fit.readings - free : 0;
    fit.reduced_chi_squared =
        fit.chi_squared / static_cast<double>(std::max<std::size_t>(fit.degrees_of_freedom, 1));
}

/// Jᵀ N⁻¹ U: the contribution of each term, by its name, to the gradient by the joint parameters.
std::map<std::string, Eigen::VectorXd>
gradients_of_terms(std::span<const ObservedRecording> recordings, const JointLayout& layout,
                   const Fit& fit) {
    const Eigen::VectorXd none =
        Eigen::VectorXd::Zero(static_cast<Eigen::Index>(layout.ids.size()));
    std::map<std::string, Eigen::VectorXd> gradients;
    for (std::size_t m = 0; m < fit.parts.size(); ++m) {
        if (!recordings[m].errors)
            continue;
        const Eigen::MatrixXd jacobian = whitened_jacobian(fit.parts[m]);
        for (const ReadingErrors::Term& term : recordings[m].errors->terms) {
            const Eigen::VectorXd own =
                jacobian.transpose() * whitened_term(term, fit.parts[m], jacobian);
            Eigen::VectorXd& sum = gradients.try_emplace(term.name, none).first->second;
            for (std::size_t k = 0; k < layout.shares[m].size(); ++k)
                sum(static_cast<Eigen::Index>(layout.shares[m][k].place)) +=
                    layout.shares[m][k].factor * own(static_cast<Eigen::Index>(k));
        }
    }
    return gradients;
}

} // namespace

void add_statistics(std::span<const ObservedRecording> measurements, const JointLayout& layout,
                    const std::vector<bool>& is_held, Fit& fit) {
    double sum_of_squares = 0.0;
    for (std::size_t m = 0; m < fit.parts.size(); ++m)
        sum_of_squares += add_residuals(measurements[m], fit.parts[m]);
    add_sums(layout, is_held, sum_of_squares, fit);
    add_covariance(layout, is_held, fit);
    for (std::size_t m = 0; m < fit.parts.size(); ++m) {
        RecordingFit& part = fit.parts[m];
        add_covariance(layout.shares[m], fit.covariance, part);
        add_parameters(part);
        say_bounds(part.parameters, held_of(layout.shares[m], is_held), part.reason);
        std::vector<std::size_t>& places = fit.places.emplace_back();
        for (const JointLayout::Share& share : layout.shares[m])
            places.push_back(share.place);
    }
    for (std::size_t k = 0; k < layout.ids.size(); ++k) {
        const auto [model, parameter] = layout.owners[k];
        fit.parameters.push_back(fit.parts[model].parameters[parameter]);
        fit.parameters.back().id = layout.ids[k];
    }
    say_bounds(fit.parameters, is_held, fit.reason);
}

StemModel linear_start(const RecordingFit& stated, const ObservedRecording& recording) {
    StemModel start = beside_errors(stated.model, recording);
    if (!recording.errors || recording.errors->terms.empty())
        return start;
    const std::vector<ReadingErrors::Term>& terms = recording.errors->terms;
    const Eigen::MatrixXd jacobian = whitened_jacobian(stated);
    const auto fitted = static_cast<Eigen::Index>(stated.model.first_error());
    const Eigen::Index count = fitted + static_cast<Eigen::Index>(terms.size());
    Eigen::MatrixXd columns(jacobian.rows(), count);
    columns.leftCols(fitted) = jacobian.leftCols(fitted);
    for (std::size_t k = 0; k < terms.size(); ++k) {
        columns.col(fitted + static_cast<Eigen::Index>(k)) =
            whitened_term(terms[k], stated, jacobian);
        if (const FittedParameter* found = stated.find({{}, terms[k].name, {}}))
            start.error_values[k] = found->value;
    }
    const Eigen::MatrixXd residuals = whitened_residuals(stated).transpose(); // a row is a frame
    const Eigen::VectorXd step =
        linear_step(columns, residuals.reshaped(), fitted, count - fitted).change;
    for (std::size_t k = 0; k < terms.size(); ++k)
        if (!terms[k].is_in_every_model &&
            std::abs(step(fitted + static_cast<Eigen::Index>(k))) > contradiction)
            return start; // too far off to be linear
    for (Eigen::Index k = 0; k < count; ++k)
        start.set_value(static_cast<std::size_t>(k),
                        start.value(static_cast<std::size_t>(k)) + step(k));
    return start;
}

void add_input_uncertainty(std::span<const ObservedRecording> recordings, double misfit, Fit& fit) {
    const JointLayout layout = joint_layout(start_from(fit), recordings);
    InverseInformation known = inverse_information(joint_information(layout, fit));
    const Eigen::MatrixXd inverse = known.inverse;
    known.inverse *= std::max(1.0, misfit);
    std::map<std::string, Eigen::VectorXd> changes = gradients_of_terms(recordings, layout, fit);
    for (auto& [name, change] : changes) {
        change = inverse * change;
        if (std::ranges::find(fit.parameters, physics::ParameterId{{}, name, {}},
                              &FittedParameter::id) != fit.parameters.end())
            change.setZero(); // the fit determines the term itself
        known.inverse += change * change.transpose();
    }
    fit.covariance = covariance_of(known);
    for (std::size_t m = 0; m < fit.parts.size(); ++m) {
        RecordingFit& part = fit.parts[m];
        add_covariance(layout.shares[m], fit.covariance, part);
        add_standard_errors(part);
        const std::size_t terms = recordings[m].errors ? recordings[m].errors->terms.size() : 0;
        part.input_changes.resize(static_cast<Eigen::Index>(layout.shares[m].size()),
                                  static_cast<Eigen::Index>(terms));
        for (std::size_t t = 0; t < terms; ++t)
            for (std::size_t k = 0; k < layout.shares[m].size(); ++k)
                part.input_changes(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(t)) =
                    layout.shares[m][k].factor *
                    changes.at(recordings[m].errors->terms[t].name)(
                        static_cast<Eigen::Index>(layout.shares[m][k].place));
    }
    for (std::size_t k = 0; k < layout.ids.size(); ++k)
        fit.parameters[k].standard_error =
            fit.parts[layout.owners[k].model].parameters[layout.owners[k].parameter].standard_error;
}

} // namespace culm::fit
