// SPDX-License-Identifier: BSD-3-Clause
// The cost of a fit, in batches of lanes: the published chain of each recording, and each effect of
// the library beside it, from the columns of the effect to the linear solution with error terms.
//
//   bench_fit_batches MEASUREMENT...
#include "core/lanes.hpp"
#include "core/order_statistics.hpp"
#include "diagnose/models/stem_fit.hpp"
#include "fit/fit_model.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/core.h>

int main(int argc, char** argv) {
    using namespace culm;
    std::vector<double> all;
    std::vector<std::vector<std::string>> rows; // (effects)(recordings)
    std::vector<std::string> names{"published chain"};
    for (const std::string& name : physics::effect_names())
        names.push_back(name);
    rows.resize(names.size());
    fmt::print("| batches of {} lanes |", core::lane_count);
    for (int k = 1; k < argc; ++k) {
        const measure::Measurement measurement = measure::read_measurement(argv[k]);
        fmt::print(" {} |", measurement.stem.id);
        const fit::BaselineFit baseline = fit::fit_baseline({&measurement, 1});
        rows[0].push_back(fmt::format("{}", baseline.fit.batches));
        for (std::size_t e = 1; e < names.size(); ++e) {
            const fit::Fit fit = diagnose::fit_larger(physics::parse_effects(names[e], {}),
                                                      baseline.fit, baseline.recordings);
            if (fit.batches > 0)
                all.push_back(fit.batches);
            rows[e].push_back(fmt::format("{}{}", fit.batches, fit.failed() ? " failed" : ""));
        }
    }
    fmt::print("\n|---|");
    for (int k = 1; k < argc; ++k)
        fmt::print("---:|");
    for (std::size_t e = 0; e < names.size(); ++e) {
        fmt::print("\n| {} |", names[e]);
        for (const std::string& cell : rows[e])
            fmt::print(" {} |", cell);
    }
    fmt::print("\nadded effects: median {:.0f}, largest {:.0f}\n", core::median(all),
               *std::ranges::max_element(all));
    return 0;
}
