// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target: the text of a study file, its design and its identity.
#include "study/config/study_config.hpp"

#include "fuzz/fuzz_input.hpp"
#include "study/design/design.hpp"
#include "study/execute/plan.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace culm;
    fuzz::may_refuse([&] {
        const study::StudyConfig config =
            study::parse_config(fuzz::text_of(data, size), "/nowhere/study.toml");
        static_cast<void>(study::difference(config.identity(), ""));
        constexpr std::int64_t quickly_made = 2000;
        if (study::point_count_of(config) > quickly_made)
            return;
        const study::Design design = study::make_design(config);
        study::check_points(config, design, {});
    });
    return 0;
}
