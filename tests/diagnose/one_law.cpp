// SPDX-License-Identifier: BSD-3-Clause
// A law of the stem that lies between two of culm's is one missing effect and not two.
#include "beam_generator/random_case.hpp"
#include "diagnosis_records.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

/// Inner friction that is strong and clearly seen (five times the noise): the beam's loss is
/// constant over its band, the chain's nearly so, and a second inner loss repairs the difference.
TEST(OneLaw, OfInnerFrictionIsNamedByItsFamilyAndNotAsTwo) {
    beam::RandomCase hidden = beam::random_case(8, beam::CaseKind::Single, 24);
    ASSERT_EQ(hidden.spec.effects.front().name, "hysteretic_damping");
    const std::vector<measure::Measurement> recordings{beam::record(hidden.spec)};
    diagnose::DiagnosisOptions options =
        quick_diagnosis("hysteretic_damping,relaxation,quadratic_drag");
    options.null_draws = 0;
    const diagnose::Diagnosis found = diagnose::diagnose(recordings, options);

    ASSERT_EQ(found.conclusion, diagnose::Conclusion::Effect) << found.reason;
    ASSERT_EQ(found.families.size(), 1u);
    EXPECT_EQ(found.families.front().family, physics::Family::MaterialDamping);
    EXPECT_EQ(found.families.front().members, found.ties.front().names);
    ASSERT_EQ(found.effects.size(), 1u) << ::testing::PrintToString(found.effects);
    ASSERT_EQ(found.ties.size(), 1u);
    std::vector<std::string> names = found.ties.front().names;
    EXPECT_EQ(names.front(), found.effects.front());
    std::ranges::sort(names);
    EXPECT_EQ(names, (std::vector<std::string>{"hysteretic_damping", "relaxation"}));
    EXPECT_EQ(found.ladder.size(), 2u);
    EXPECT_EQ(found.ladder.back().fit.names.back(), found.effects.front());
    EXPECT_GT(found.explained, 0.99);
}

} // namespace
} // namespace culm::tests
