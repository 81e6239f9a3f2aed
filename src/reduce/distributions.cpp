// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/distributions.hpp"

#include <cmath>

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace culm::reduce {

double student_t_factor(std::size_t degrees_of_freedom) {
    const boost::math::students_t distribution(static_cast<double>(degrees_of_freedom));
    const double tail = 0.5 * (1.0 - confidence_level);
    return boost::math::quantile(boost::math::complement(distribution, tail));
}

double student_t_p_value(double t, std::size_t degrees_of_freedom) {
    if (std::isinf(t))
        return 0.0;
    const boost::math::students_t distribution(static_cast<double>(degrees_of_freedom));
    return 2.0 * boost::math::cdf(boost::math::complement(distribution, std::abs(t)));
}

double fisher_f_p_value(double f, std::size_t numerator, std::size_t denominator) {
    if (f <= 0.0)
        return 1.0;
    if (std::isinf(f))
        return 0.0;
    const boost::math::fisher_f distribution(static_cast<double>(numerator),
                                             static_cast<double>(denominator));
    return boost::math::cdf(boost::math::complement(distribution, f));
}

} // namespace culm::reduce
