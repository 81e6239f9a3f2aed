// SPDX-License-Identifier: BSD-3-Clause
// A named piece of physics that can be added to the published chain, and the changes along the stem
// that several of them make.
#pragma once

#include "physics/chain_model.hpp"

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace culm::physics {

/// The number that a fit works on; in the order of the names in to_string().
enum class FittedAs {
    Itself,
    Logarithm, ///< spans decades and is positive
    Inverse    ///< a stiffness whose compliance is the effect; infinite: no effect
};

/// "as it is", "as its logarithm", "as its inverse".
[[nodiscard]] std::string_view to_string(FittedAs fitted_as);

/// Which statement of a recording gives the value of a parameter that is known, not fitted.
enum class StatedBy {
    Nobody,
    AxialGravity,      ///< minus the acceleration of gravity where it acts along the stem, else 0
    TransverseGravity, ///< the same, positive, where it acts across the stem
    HoldTime           ///< for how long the stem was held before the release
};

/// Relative distance from a natural frequency within which a load from outside is excluded.
inline constexpr double near_resonance = 0.05;

/// Scales for start values, from a fit of the smaller model.
struct StartScales {
    double length = 0.0;          ///< of the stem, m
    double duration = 0.0;        ///< of the recording after the release, s
    double first_frequency = 0.0; ///< of the stem, Hz
    double stiffness = 0.0;       ///< E I/L, N m/rad
    double mass = 0.0;            ///< of the stem, kg
    /// Frequencies at which the residuals are strongest, Hz; computing them takes a while.
    std::function<std::vector<double>()> residual_peaks;
};

/// A beat in the readings, caused by two planes of bending with different frequencies.
struct ObservedBeat {
    double split = 0.0; ///< difference of the two stiffnesses over their mean
    double angle = 0.0; ///< from the plane of the pull to the stiffer principal plane, rad
};

/// A number of an effect, in SI units.
struct EffectParameter {
    std::string name; ///< with its unit at the end where it has one, as in stiffness_nm_rad
    std::string unit; ///< for people; empty for a pure number
    std::string meaning;
    double default_value = 0.0;
    double lower = 0.0; ///< physically possible range
    double upper = 0.0;
    double scale = 0.0; ///< a typical size, for differences and step lengths
    FittedAs fitted_as = FittedAs::Itself;
    bool calibrated = true; ///< fitted unless the user fixes it; false: known, like gravity
    /// A location, an angle or a time scale, which has no meaning while the effect has no size.
    bool is_place = false;
    bool is_phase = false; ///< a place in rad whose effect is that of a vector with this direction
    double absent = 0.0;   ///< of a size: value without the effect; for Inverse it is `upper`
    StatedBy stated_by = StatedBy::Nobody;
    /// The frequency of a load from outside, Hz. Within near_resonance of a natural frequency such
    /// a load cannot be told from another frequency of the stem, and no fit ends there.
    bool is_excitation = false;
    /// Standard deviation within which the default is known, for example from the literature; a fit
    /// uses it as a reading. 0: nothing is known.
    double known_within = 0.0;
    /// Start values of a fit, tried in turn: of a location, an angle or a time scale, and of a size
    /// that a fit cannot reach from a model without the effect. Null: only the default.
    std::vector<double> (*start_values)(const StartScales& scales) = nullptr;
    /// The start that a beat in the readings suggests; null: a beat does not determine it.
    double (*start_from_beat)(const ObservedBeat& beat) = nullptr;
};

/// Values of a parameter that is only a size.
struct ParameterSize {
    double default_value;
    double lower;
    double upper;
    double scale;
};
[[nodiscard]] inline EffectParameter
size_parameter(const char* name, const char* unit, const char* meaning, const ParameterSize& size,
               std::vector<double> (*start_values)(const StartScales&) = nullptr) {
    EffectParameter parameter{name,       unit,       meaning,   size.default_value,
                              size.lower, size.upper, size.scale};
    parameter.start_values = start_values;
    return parameter;
}

/// The same for a location, an angle or a time scale, with the start values of a fit.
[[nodiscard]] inline EffectParameter
place_parameter(const char* name, const char* unit, const char* meaning, const ParameterSize& size,
                std::vector<double> (*start_values)(const StartScales&),
                FittedAs fitted_as = FittedAs::Itself) {
    EffectParameter parameter = size_parameter(name, unit, meaning, size, start_values);
    parameter.fitted_as = fitted_as;
    parameter.is_place = true;
    return parameter;
}

/// Time for which the stem was held before the release; known from the measurement.
[[nodiscard]] inline EffectParameter hold_time_parameter() {
    EffectParameter parameter =
        size_parameter("hold_time_s", "s", "t_h: for how long the stem was held before the release",
                       {.default_value = 10.0, .lower = 0.0, .upper = 1e7, .scale = 10.0});
    parameter.calibrated = false;
    parameter.stated_by = StatedBy::HoldTime;
    return parameter;
}

/// Owner of an effect. Recordings of the same owner have the same values.
enum class BelongsTo {
    Stem,      ///< and therefore to all its recordings
    Recording, ///< each recording has its own values
    Rig        ///< clamp, camera, air: to all recordings made there; so far fitted like the stem's
};

/// Laws of one family differ in form, not in kind: a recording may determine the family but not
/// the law. In the order of the names in to_string().
enum class Family {
    MaterialDamping,
    Air,
    Clamp,
    StemGeometry,
    SupportAndCamera,
    Release,
    Weight,
    Own ///< of a user's law, a family without other laws
};
/// "material damping", "air", …
[[nodiscard]] std::string_view to_string(Family family);

/// Do two laws of the family that act together form one law? A drag whose power lies between 1
/// and 2 is one drag, and an inner loss over another band is one loss.
[[nodiscard]] bool is_one_law(Family family);

/// An experiment that shows the effect because it changes or removes it.
struct RevealingExperiment {
    std::string what;            ///< an instruction; effects that share it change together
    std::vector<double> factors; ///< of the effect's parameters, in their order
};

/// A planar chain whose weighted motion is a part of the observed motion of a spatial one.
struct PlanarPart {
    double weight = 1.0;
    double modulus_factor = 1.0; ///< of Y
};

/// A point mass on the stem.
struct AttachedMass {
    double position = 0.0; ///< from the clamp along the stem, m; beyond the tip: mounted at the tip
    double mass = 0.0;     ///< kg
};

/// Errors of the camera, not of the stem. Zeros: a global shutter at a right angle.
struct CameraView {
    /// Delay from the row at the clamp to the row at the height of the stem's free length, s;
    /// negative if the clamp's row is read later.
    double readout_time = 0.0;
    /// Share by which deflections at the tip's row are read too large; it is zero at the clamp.
    double scale_change = 0.0;

    friend bool operator==(const CameraView&, const CameraView&) = default;
};

/// The stem that effects change.
struct EffectTarget {
    const StemParameters<double>& stem;
    const BondLawOptions& law;
    ChainModel<double>& model;
    CameraView& camera;
    /// Added to the spheres after all effects: an effect that scales the stem's own mass (a taper)
    /// must not scale attached masses.
    std::vector<AttachedMass> attached = {};
};

/// Expands a list whose single entry applies to the whole chain of `sphere_count` spheres.
void expand_links(ChainModel<double>& model, int sphere_count);

/// Properties of the stem at `position` (m from the clamp), derived from those of the whole stem.
using LocalStem =
    std::function<StemParameters<double>(StemParameters<double> stem, double position)>;

/// Multiplies stiffness and damping of every bond, and mass and inertia of every sphere, by the
/// ratio of the bond law's values for the local stem to those for the whole stem. The local stem is
/// that at the middle of a bond and at the centre of a sphere. Several changes may be applied in
/// any order. The lengths and lever arms of the bonds do not change.
void change_along_stem(EffectTarget& target, const LocalStem& local);

/// Adds the target's attached masses to the spheres, each shared by the two nearest so that its
/// centre is right. The bonds' damping stays that of the stem. Throws core::InputError for a
/// position below the clamp.
void join_attached_masses(EffectTarget& target);

/// Adds an effect to the target; `values` in the order of its parameters.
using ApplyEffect = std::function<void(std::span<const double> values, EffectTarget& target)>;
/// Narrows defaults, bounds and scales to sensible values for one stem.
using SuitParameters = void (*)(const StemParameters<double>& stem,
                                std::span<EffectParameter> parameters);

/// All that describes an effect, except what it does.
struct EffectCard {
    std::string name;
    Family family = Family::Own;
    std::string summary; ///< what it is, one line
    std::string law;     ///< its equation, as text
    std::string source;  ///< a citation
    /// Its signature in a recording, and the remedy in the laboratory or in the study.
    std::string signature;
    std::string remedy;
    /// Energy that it stores, and energy that it supplies or dissipates (computed in energy.hpp).
    std::string energy;
    std::vector<EffectParameter> parameters;
    /// Effects that describe the same physics and cannot be combined with this one.
    std::vector<std::string> excludes = {};
    int dimensions = 2; ///< 3 if the motion leaves the plane of the pull
    BelongsTo belongs_to = BelongsTo::Stem;
    std::vector<RevealingExperiment> revealed_by = {};
    /// Is its law defined over the whole length, so that a part of the stem needs another law?
    bool spans_the_stem = false;
    bool is_of_the_release = false; ///< it acts only while the stem is released
    bool is_of_the_camera = false;  ///< it changes the pictures of a camera only
    bool needs_edges = false;       ///< it acts on stems of a rectangular section only
    /// Planar chains that together describe the observed motion if it leaves the plane slightly;
    /// null: the effect acts in the plane.
    std::vector<PlanarPart> (*planar_parts)(std::span<const double> values) = nullptr;
};

/// One effect of the library or of a user: its card, and what it does.
class Effect : public EffectCard {
  public:
    Effect(EffectCard card, ApplyEffect how, SuitParameters suit)
        : EffectCard(std::move(card)), apply_(std::move(how)), suit_(suit) {}

    /// The parameters with defaults, bounds and scales for one stem, which define the start and the
    /// range of a fit. The bounds lie within those of `parameters`, which are valid for every stem.
    [[nodiscard]] std::vector<EffectParameter>
    parameters_for(const StemParameters<double>& stem) const;
    /// The card's planar parts; empty if the effect acts in the plane.
    [[nodiscard]] std::vector<PlanarPart> planar_parts_of(std::span<const double> values) const;
    /// Adds the effect; `values` in the order of `parameters`.
    void apply(std::span<const double> values, EffectTarget& target) const {
        apply_(values, target);
    }

  private:
    ApplyEffect apply_;
    SuitParameters suit_;
};

using EffectPointer = std::shared_ptr<const Effect>;

/// An effect with the values of its parameters, in their order.
struct ActiveEffect {
    EffectPointer effect;
    std::vector<double> values;
};

[[nodiscard]] inline EffectPointer make_effect(EffectCard card, ApplyEffect apply,
                                               SuitParameters suit = nullptr) {
    return std::make_shared<Effect>(std::move(card), std::move(apply), suit);
}

} // namespace culm::physics
