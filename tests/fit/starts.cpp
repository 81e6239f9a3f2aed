// SPDX-License-Identifier: BSD-3-Clause
// Several starts are needed for each recording here, and the linear estimate finds the best one.
#include "fit/start/starts.hpp"

#include "beam_generator/recording.hpp"
#include "fit/fit_model.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "physics/effects/library.hpp"
#include "support/parameter_ids.hpp"
#include "support/single_fit.hpp"

#include <algorithm>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

/// A recording of the beam generator; a chain of 28 spheres makes the fit quick.
fit::ObservedRecording recording_with(beam::HiddenEffect effect) {
    beam::RecordingSpec spec;
    spec.effects = {std::move(effect)};
    spec.heights = beam::even_heights(spec.stem.length, 6);
    spec.duration = 0.2;
    spec.errors.noise = 0.05e-3;
    fit::ObservedRecording recording(beam::record(spec));
    recording.stem.spheres = 28;
    return recording;
}

class Starts {
  public:
    Starts(beam::HiddenEffect hidden, const char* fitted)
        : recording_(recording_with(std::move(hidden))), smaller_(fit_baseline(recording_)),
          effects_(physics::parse_effects(fitted, {})),
          model_(fit::candidate_model(smaller_.parts.front().model, effects_, recording_)) {}

    /// χ² above the number of readings, where a fit from this start alone ends; that of the smaller
    /// model if it fails.
    [[nodiscard]] double excess_from(const fit::StemModel& start) const {
        return excess(fit::fit_near({{start}}, effects_, smaller_, {&recording_, 1}, {}));
    }
    [[nodiscard]] double excess_of_policy() const {
        return excess(fit_candidate(effects_, smaller_, recording_));
    }
    [[nodiscard]] std::vector<fit::StemModel> candidates() const {
        return fit::fit_starts(model_, smaller_.parts.front(), fit::StartSize::Absent);
    }
    [[nodiscard]] std::vector<double> excess_from_each() const {
        std::vector<double> found;
        for (const fit::StemModel& start : candidates())
            found.push_back(excess_from(start));
        return found;
    }

  private:
    [[nodiscard]] double excess(const fit::Fit& fit) const {
        const fit::Fit& counted = fit.is_fitted() ? fit : smaller_;
        return counted.chi_squared - static_cast<double>(counted.readings);
    }

    fit::ObservedRecording recording_;
    fit::Fit smaller_;
    fit::SelectedEffects effects_;
    fit::StemModel model_;
};

/// The best of several starts is found, and one of them alone would miss it by far.
void expect_that_one_start_is_too_few(const Starts& starts) {
    const std::vector<double> each = starts.excess_from_each();
    ASSERT_GE(each.size(), 2u);
    const double best = std::ranges::min(each);
    const double worst = std::ranges::max(each);
    EXPECT_GT(worst, best + 25.0); // five standard deviations
    EXPECT_LT(starts.excess_of_policy(), best + 1.0);
}

TEST(Starts, AreSeveralForALocation) {
    expect_that_one_start_is_too_few(Starts(
        {"local_defect", {{"position_m", 0.05}, {"stiffness_factor", 0.3}}}, "local_defect"));
}

// At these places a stiff segment elsewhere changes the modes as the weak one does.
TEST(Starts, LeadToADefectWhereItIs) {
    const beam::RecordingSpec spec;
    for (const double place : {0.2, 0.5}) {
        const double position = place * spec.stem.length;
        const fit::ObservedRecording recording =
            recording_with({"local_defect", {{"position_m", position}, {"stiffness_factor", 0.3}}});
        const fit::Fit found = fit_candidate(physics::parse_effects("local_defect", {}),
                                             fit_baseline(recording), recording);
        ASSERT_TRUE(found.is_fitted()) << found.reason;
        EXPECT_NEAR(found.parts.front().find(id("local_defect.position_m"))->value, position,
                    0.02 * spec.stem.length);
        EXPECT_NEAR(found.parts.front().find(id("local_defect.stiffness_factor"))->value, 0.3, 0.1);
    }
}

TEST(Starts, AreSeveralForAFrequency) {
    expect_that_one_start_is_too_few(
        Starts({"base_motion", {{"amplitude_m", 4e-4}, {"frequency_hz", 31.0}, {"phase_rad", 0.7}}},
               "base_motion"));
}

// A defect fitted to a clamp that yields: the valley is long, and its steps meet bounds.
TEST(Solutions, EndWhereARestartGainsNothing) {
    fit::ObservedRecording recording(measure::read_measurement(
        std::filesystem::path(CULM_TEST_DATA_DIR) / "hidden-effect" / "T3-clamp_compliance"));
    recording.stem.spheres = 12;
    const fit::Fit smaller = fit_baseline(recording);
    const fit::SelectedEffects effects = physics::parse_effects("local_defect", {});
    const fit::StemModel model =
        fit::candidate_model(smaller.parts.front().model, effects, recording);
    for (const fit::StemModel& start :
         fit::fit_starts(model, smaller.parts.front(), fit::StartSize::Absent)) {
        fit::JointOptions once;
        const fit::Fit one = fit::fit_jointly({&start, 1}, {&recording, 1}, once);
        const fit::Fit again = fit::fit_jointly(fit::start_from(one), {&recording, 1}, once);
        const double unit = one.weighted_rms * one.weighted_rms; // of χ² by one standard error
        EXPECT_LT(std::pow(one.weighted_rms, 2) - std::pow(again.weighted_rms, 2),
                  3.0 * unit / static_cast<double>(one.readings));
    }
}

TEST(StartsByFrequency, GiveEachRecordingTheFirstModeOfItsReadings) {
    const double mass = 60e-6; // the first mode falls to a half
    std::vector<fit::ObservedRecording> two;
    for (const double hidden : {0.0, mass})
        two.push_back(recording_with({"tip_mass", {{"mass_kg", hidden}}}));
    const fit::SelectedEffects effects = physics::parse_effects("tip_mass", {});
    fit::StartModels models;
    for (const fit::ObservedRecording& each : two)
        models.push_back(fit::observed_model(effects, each));
    const auto starts = fit::starts_by_frequency(models, "tip_mass", two);
    ASSERT_EQ(starts.size(), 1U) << "only the lighter recording can be without a mass";
    const auto mass_in = [&](std::size_t m) {
        return starts.front()[m].spec.effects.back().values.front();
    };
    EXPECT_EQ(mass_in(0), 0.0);
    EXPECT_NEAR(mass_in(1), mass, 0.03 * mass); // Eq. 1 follows both modes
    EXPECT_EQ(starts.front()[0].spec.stem.bond_youngs_modulus,
              starts.front()[1].spec.stem.bond_youngs_modulus);
    EXPECT_TRUE(fit::starts_by_frequency({fit::observed_model(effects, two.front())}, "tip_mass",
                                         {two.data(), 1})
                    .empty());
}

} // namespace
} // namespace culm::tests
