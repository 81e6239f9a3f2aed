// SPDX-License-Identifier: BSD-3-Clause
// Everything that a beam may have beyond a uniform, linear, rigidly clamped stem in vacuum.
#pragma once

#include <optional>
#include <vector>

namespace culm::beam {

/// Y is multiplied by `stiffness_factor` over `length` around `position`.
struct WeakSegment {
    double position = 0.0; ///< of its middle, m from the clamp
    double length = 0.0;   ///< m
    double stiffness_factor = 1.0;
};

/// A spring and a dashpot in series, parallel to the bending stiffness: q̇ = g E I κ̇ − q/τ.
struct RelaxingBranch {
    double fraction = 0.0;   ///< g
    double time = 1.0;       ///< τ, s
    double held_share = 0.0; ///< share of g E I κ that remains at the release
};

/// Moment on the beam's first cross-section: −k θ − c θ̇ − M tanh(θ̇/ω_r).
struct TurningClamp {
    double stiffness = 0.0;       ///< k, N m/rad
    double friction_moment = 0.0; ///< M, N m
    double friction_rate = 0.05;  ///< ω_r, rad/s
    double damping = 0.0;         ///< c, N m s/rad
};

/// Force per length c |v|ᵖ⁻¹ v.
struct PowerDrag {
    double coefficient = 0.0; ///< c, N sᵖ/m¹⁺ᵖ
    double exponent = 2.0;    ///< p > 1
};

/// The spring of a turning clamp slips (Bouc and Wen): its moment z grows by dz = k dθ (1 − s |z|ⁿ)
/// while |z| grows, and by k dθ while it falls.
struct SlippingSpring {
    double share = 0.0; ///< s, (N m)⁻ⁿ
    double power = 1.0; ///< n
};

/// Morison's equation with coefficients that depend on the amplitude A at each section, KC = 2πA/W:
/// drag ½ρW D KC^(−1/3) |v| v and added mass ¼πρW² (k₀ + k KC^(2/3)). A² = y² + (v/ω)².
struct AirAround {
    double width = 0.0;             ///< W, m
    double drag = 0.0;              ///< D
    double mass = 0.0;              ///< k
    double still_mass = 0.0;        ///< k₀
    double angular_frequency = 1.0; ///< ω, rad/s
};

/// M = E I δ (|κ|/κ_r)ᵖ κ̇.
struct StrainLoss {
    double time = 0.0; ///< δ, s
    double power = 1.0;
    double curvature = 1.0; ///< κ_r, 1/m
};

/// A spring and a dashpot that act on the motion of the second mode alone, and not on the held
/// stem: the dispersion of a material, whose static stiffness is another one.
struct SecondMode {
    double frequency_share = 0.0; ///< by which its natural frequency is larger
    double loss_ratio = 1.0;      ///< of its internal damping to that of the material
};

/// The support moves by a sin(2πft + φ).
struct SupportVibration {
    double amplitude = 0.0; ///< a, m
    double frequency = 0.0; ///< f, Hz
    double phase = 0.0;     ///< φ, rad
};

/// The tip is drawn toward its rest position from both sides, most at the distance `reach`:
/// −F (y/b) exp(½ − ½ (y/b)²), which stiffens small motions and softens large ones.
struct TipMagnet {
    double force = 0.0; ///< F, N
    double reach = 0.0; ///< b, m
};

/// A cable at the tip whose drag is largest at one speed: −F · 2 (v/v0)/(1 + (v/v0)²).
struct LossyCable {
    double force = 0.0; ///< F, N
    double speed = 0.0; ///< v0, m/s
};

/// A solid object next to the stem: it pushes back a material point that moves beyond −gap.
struct ImpactStop {
    double height = 0.0;    ///< of the material point on the straight stem, m
    double gap = 0.0;       ///< m
    double stiffness = 0.0; ///< N/m
    double damping = 0.0;   ///< N s/m, while in contact
};

/// A term that is zero or empty is absent.
struct BeamTerms {
    double taper = 0.0;              ///< d(s) = d [1 + r (s/L − ½)]
    double stiffness_gradient = 0.0; ///< Y(s) = Y [1 + r (s/L − ½)]
    std::optional<WeakSegment> segment;
    double base_curvature = 0.0; ///< of the stem at rest, linear along it, 1/m
    double tip_curvature = 0.0;
    double cubic_bending = 0.0; ///< γ of E I κ (1 + γ κ²), m²
    /// The section has two principal planes, the motion two directions: E I (1 ± split/2).
    bool is_spatial = false;
    double stiffness_split = 0.0;
    double split_angle = 0.0; ///< from the plane of the pull to the stiffer plane, rad
    std::vector<RelaxingBranch> branches;
    double curvature_damping = 0.0; ///< δ of M = E I δ κ² κ̇, m² s
    std::optional<StrainLoss> strain_loss;
    std::optional<TurningClamp> clamp;
    std::optional<SlippingSpring> slip; ///< of the clamp
    std::optional<SecondMode> second_mode;

    double linear_drag = 0.0;    ///< force per length over speed, N s/m²
    double quadratic_drag = 0.0; ///< N s²/m³
    double cubic_drag = 0.0;     ///< N s³/m⁴
    std::optional<PowerDrag> power_drag;
    std::optional<AirAround> air;
    double axial_gravity = 0.0; ///< m/s², positive away from the clamp
    double transverse_gravity = 0.0;
    double tip_mass = 0.0; ///< kg
    std::optional<SupportVibration> support;
    double release_duration = 0.0; ///< s; the finger's force falls as 1 − 3u² + 2u³

    std::optional<TipMagnet> magnet;
    std::optional<LossyCable> cable;
    std::optional<ImpactStop> stop;
};

} // namespace culm::beam
