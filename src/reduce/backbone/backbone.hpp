// SPDX-License-Identifier: BSD-3-Clause
// The backbone of a recording: frequency and damping ratio of its modes against their amplitude,
// from the readings alone.
//
// In windows of eight cycles of a mode, each beginning in the middle of the one before, the mode is
// fitted together with the others (damped_modes.hpp). The frequency of the others is that of the
// whole record unless the window determines it. The amplitude is that in the middle of the window
// at the height where the mode is largest; readings of speed or acceleration are divided by ω or
// ω².
#pragma once

#include "reduce/backbone/amplitude_laws.hpp"
#include "reduce/backbone/damped_modes.hpp"

#include <string>
#include <vector>

namespace culm::reduce {

struct BackboneInput {
    HeightHistories histories;
    std::vector<double> heights;  ///< (heights) m
    std::vector<int> derivatives; ///< (heights) 2: an acceleration
    double last = 0.0;            ///< s; 0: all times
    bool has_deflections = true;  ///< false: readings of strain
};

struct ModeBackbone {
    std::size_t mode = 1;
    double height = 0.0;    ///< of the amplitudes, m
    bool is_strain = false; ///< amplitudes are strains
    std::vector<BackbonePoint> points;
    std::optional<AmplitudeLaws> laws;       ///< empty: too few points, or one amplitude
    std::optional<AmplitudeClass> signature; ///< of mode 1
    std::string reason;                      ///< why there are no laws
};

/// Amplitudes are deflections, or strains in mm/m.
template <class To>
void describe(To& to, const ModeBackbone& backbone) {
    to("mode", backbone.mode);
    to("height_mm", backbone.height);
    to("is_strain", backbone.is_strain);
    to("points", backbone.points);
    to("laws", backbone.laws);
    to("signature", [&] {
        return backbone.signature ? std::optional(to_string(*backbone.signature)) : std::nullopt;
    });
    to("reason", backbone.reason);
}

/// The readings after the release, up to the last time.
[[nodiscard]] HeightHistories free_part(const BackboneInput& input);

/// Backbones of the first modes that the readings show, at most `count`.
[[nodiscard]] std::vector<ModeBackbone> backbones(const BackboneInput& input,
                                                  std::size_t count = 2);

} // namespace culm::reduce
