// SPDX-License-Identifier: BSD-3-Clause
// One case: everything that a single free-vibration run needs, and its result, as plain data in SI
// units.
#pragma once

#include "core/error.hpp"
#include "integrate/solve_summary.hpp"
#include "integrate/sundials/integrator.hpp"
#include "measure/folder/measurement.hpp"
#include "physics/bond_law_options.hpp"
#include "physics/effects/effect.hpp"
#include "physics/stem.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace culm::run {

enum class IntegrationMethod {
    Implicit, ///< culm's own RODAS5, one stem per SIMD lane
    Explicit, ///< velocity Verlet, one stem per SIMD lane
    Sundials, ///< implicit, by SUNDIALS
};

/// Data of a trajectory that are stored. Every level includes the ones before it.
enum class StoreLevel { Fit, Tip, Heights, Full };

/// How a case is integrated in time.
struct Integrator {
    IntegrationMethod method = IntegrationMethod::Implicit;
    double timestep = 0.0;               ///< s; explicit only
    double relative_tolerance = 2e-6;    ///< implicit methods only
    std::int64_t step_limit = 2'000'000; ///< implicit methods only: a case that needs more fails
};

/// How the stem is released.
enum class Release {
    TipPull,     ///< pulled aside at the tip, in equilibrium
    FirstMode,   ///< likewise, with forces along the stem that hold back modes 2 and 3
    HeldStraight ///< held in line with the clamp, at rest; gravity or its own curvature moves it
};

/// A higher mode that is superposed on the motion of the chain (fit/chain/higher_modes.hpp).
struct HigherMode {
    double deflection = 0.0;     ///< of the tip at the start of the record, m
    double speed = 0.0;          ///< likewise, m/s
    double log_frequency = 0.0;  ///< of its frequency over that of the chain's mode
    double softening = 0.0;      ///< relative fall of its frequency at the start of the record
    double log_loss = 0.0;       ///< of its decay rate over the recorded one
    double loss_share = 0.0;     ///< of its decay rate at the start that falls with mode 1, 0 … 1
    double recorded_decay = 0.0; ///< decay rate in the first cycles, 1/s, positive; not fitted
    double first_decay = 0.0;    ///< decay rate of mode 1, 1/s, positive; likewise
};

struct CaseSpec {
    std::int64_t point = 0; ///< index in the study's design
    physics::StemParameters<double> stem;
    physics::BondLawOptions law;
    Integrator integrator;
    int dimensions = 2;            ///< 2: planar; 3: spatial
    double tip_deflection = 15e-3; ///< lateral, before the release, m
    double duration = 0.1;         ///< of the free vibration, s
    double sample_interval = 5e-5; ///< s; explicit steps must divide it
    StoreLevel store = StoreLevel::Tip;
    std::vector<double> heights; ///< above the clamp, m; for StoreLevel::Heights
    /// (heights) what is read there; empty: rows of a camera's picture.
    std::vector<measure::Sensor> sensors;
    /// Whether displacements are those in image rows or of marks on the stem.
    measure::Reading reading = measure::Reading::Row;
    double readout_time = 0.0; ///< of the camera, known; physics::CameraView's
    Release release = Release::TipPull;
    std::array<HigherMode, 2> higher_modes{};        ///< modes 2 and 3
    std::vector<physics::AttachedMass> added_masses; ///< known
    std::vector<physics::ActiveEffect> effects;      ///< beyond the published chain

    /// Samples in every stored history, the one at t = 0 included.
    [[nodiscard]] std::size_t sample_count() const {
        return static_cast<std::size_t>(std::llround(duration / sample_interval)) + 1;
    }
};

/// Histories are sampled at k · sample_interval, k = 0 … sample_count − 1. The lateral direction is
/// that of the pull; deflections are metres from the undeformed straight axis.
struct CaseResult {
    std::vector<double> tip_deflection;    ///< (samples); always filled
    std::vector<double> height_deflection; ///< (samples, heights), row-major
    std::vector<double> positions;         ///< (samples, spheres, 3), row-major: axial, lateral,
                                           ///< out of plane; only for StoreLevel::Full
    integrate::SolveSummary work;          ///< of the integrator
    double wall_seconds = 0.0;             ///< of the case; of its share when lanes ran together
};

/// The stem of a case in the terms of its owner, for measure::stem_line(): the length is that from
/// the clamp to the tip's centre.
[[nodiscard]] measure::MeasuredStem described_stem(const CaseSpec& spec);

struct CaseFailure {
    core::FailureKind kind = core::FailureKind::NotANumber;
    std::string reason; ///< one sentence, with the time and the value at which it failed
};

using CaseOutcome = std::variant<CaseResult, CaseFailure>;

} // namespace culm::run
