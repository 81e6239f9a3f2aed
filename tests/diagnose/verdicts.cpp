// SPDX-License-Identifier: BSD-3-Clause
// Answers of the diagnosis with all candidates. The recordings were not made with the chain. Chains
// of 20 spheres have the verdicts of the default 56 in a third of the time;
// tests/cli/test_tutorial.py diagnoses T2 with every option at its default.
#include "beam_generator/random_case.hpp"
#include "diagnosis_records.hpp"

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

using diagnose::Conclusion;
using Names = std::vector<std::string>;

diagnose::Diagnosis diagnosis_of(const std::vector<measure::Measurement>& recordings) {
    diagnose::DiagnosisOptions options;
    options.candidate = quick_fit();
    return diagnose::diagnose(recordings, options);
}

struct KnownAnswer {
    std::string name;
    Conclusion conclusion;
    Names effects;
};

void PrintTo(const KnownAnswer& known, std::ostream* out) {
    *out << known.name;
}

class Verdict : public ::testing::TestWithParam<KnownAnswer> {};

TEST_P(Verdict, IsTheTruthByName) {
    const diagnose::Diagnosis found = diagnosis_of(recording(GetParam().name));
    EXPECT_EQ(found.conclusion, GetParam().conclusion) << found.reason;
    Names named;
    for (const diagnose::NamedFamily& family : found.families) {
        EXPECT_EQ(family.members.size(), 1u) << ::testing::PrintToString(family.members);
        named.push_back(family.members.front());
    }
    EXPECT_EQ(named, found.effects);
    std::ranges::sort(named);
    EXPECT_EQ(named, GetParam().effects);
}

INSTANTIATE_TEST_SUITE_P(
    Recordings, Verdict,
    ::testing::Values(KnownAnswer{"T1-null", Conclusion::Adequate, {}},
                      KnownAnswer{"T2-quadratic_drag", Conclusion::Effect, {"quadratic_drag"}},
                      KnownAnswer{"T3-clamp_compliance", Conclusion::Effect, {"clamp_compliance"}},
                      KnownAnswer{
                          "T4-bending_nonlinearity", Conclusion::Effect, {"bending_nonlinearity"}},
                      KnownAnswer{"T5-relaxation", Conclusion::Effect, {"relaxation"}},
                      KnownAnswer{"T6-clamp_friction", Conclusion::Effect, {"clamp_friction"}},
                      KnownAnswer{"T7-quadratic_drag+clamp_compliance",
                                  Conclusion::Effect,
                                  {"clamp_compliance", "quadratic_drag"}}),
    [](const auto& given) { return given.param.name.substr(0, 2); });

// A taper, a gradient and a defect change the low modes alike: only the family is determined.
TEST(VerdictOfAFamily, IsTheGeometryOfAStemThatMayTaper) {
    const beam::RandomCase hidden = beam::random_case(8, beam::CaseKind::Single, 0);
    ASSERT_EQ(hidden.spec.effects.front().name, "taper");
    const diagnose::Diagnosis found = diagnosis_of({beam::record(hidden.spec)});
    EXPECT_EQ(found.conclusion, Conclusion::Effect) << found.reason;
    ASSERT_EQ(found.families.size(), 1u);
    EXPECT_EQ(found.families.front().family, physics::Family::StemGeometry);
    const Names& members = found.families.front().members;
    EXPECT_NE(std::ranges::find(members, "taper"), members.end());
    EXPECT_GT(members.size(), 1u);
}

// The same stem bare and with a known mass at its tip. Ruler and camera have errors.
TEST(VerdictOfAPair, IsAdequateWhereOnlyInputsAreWrong) {
    beam::RecordingSpec spec = beam::random_case(8, beam::CaseKind::Null, 1).spec;
    const double mass = 0.6 * spec.stem.mass_per_length() * spec.stem.length;
    std::vector<measure::Measurement> recordings{beam::record(spec)};
    spec.id = "loaded";
    spec.effects = {{"tip_mass", {{"mass_kg", mass}}}};
    spec.duration *= 2.0;
    ++spec.seed;
    recordings.push_back(beam::record(spec));
    recordings.back().stem.added_masses = {{spec.stem.length, mass, {}}};
    for (measure::Measurement& each : recordings) {
        each.specimen = each.rig = "A";
        std::get<measure::CircularSection>(each.stem.section).diameter *= 1.015;
        for (double& height : each.heights)
            height = 1.004 * height - 0.2e-3;
        for (double& reading : each.deflections)
            reading *= 1.004;
    }
    const diagnose::Diagnosis found = diagnosis_of(recordings);
    EXPECT_EQ(found.conclusion, Conclusion::Adequate) << found.reason;
}

} // namespace
} // namespace culm::tests
