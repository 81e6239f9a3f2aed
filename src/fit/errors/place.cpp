// SPDX-License-Identifier: BSD-3-Clause
#include "fit/errors/terms.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/core.h>

namespace culm::fit {
namespace {

/// Position errors are modelled by Legendre polynomials of degree 0 to 3. Only the cubic one scales
/// the first mode by a factor that depends on the amplitude, and so changes the damping.
constexpr unsigned row_polynomials = 4;

} // namespace

std::vector<ErrorTerm> place_terms(const RecordingFit& fit,
                                   const measure::Measurement& measurement) {
    std::vector<ErrorTerm> terms;
    if (measurement.uncertainties.row.value_or(0.0) == 0.0)
        return terms;
    const std::size_t rows = fit.prediction.rows;
    std::vector<double> places = fit.prediction.readings;
    for (double& place : places)
        place = std::isfinite(place) ? place : 0.0;
    // Uses every `step`-th reading, starting with `first`.
    const auto add = [&](const std::string& of, std::size_t first, std::size_t step,
                         unsigned lowest_degree) {
        double largest = 0.0;
        for (std::size_t at = first; at < places.size(); at += step)
            largest = std::max(largest, std::abs(places[at]));
        for (unsigned degree = lowest_degree; degree < row_polynomials && largest > 0.0; ++degree) {
            ErrorTerm& term = terms.emplace_back();
            term.kind = ErrorKind::Place;
            term.id = fmt::format("{} of {}, degree {}", of, measurement.stem.id, degree);
            term.readings.assign(places.size(), 0.0);
            for (std::size_t at = first; at < places.size(); at += step)
                term.readings[at] =
                    *measurement.uncertainties.row * std::legendre(degree, places[at] / largest);
        }
    };
    for (std::size_t j = 0; j < rows; ++j)
        add(fmt::format("row at {:.6g} mm", 1e3 * measurement.heights[j]), j, rows, 0);
    add("all rows", 0, 1, 2);
    return terms;
}

} // namespace culm::fit
