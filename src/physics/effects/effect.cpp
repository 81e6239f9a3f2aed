// SPDX-License-Identifier: BSD-3-Clause
#include "physics/effects/effect.hpp"

namespace culm::physics {

std::string_view to_string(FittedAs fitted_as) {
    switch (fitted_as) {
    case FittedAs::Itself:
        return "as it is";
    case FittedAs::Logarithm:
        return "as its logarithm";
    case FittedAs::Inverse:
        return "as its inverse";
    }
    return "as it is";
}

} // namespace culm::physics
