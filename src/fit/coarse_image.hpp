// SPDX-License-Identifier: BSD-3-Clause
// A fit as a chain of few spheres sees it: the search goes on there, for less than half the time.
#pragma once

#include "fit/fit_model.hpp"
#include "fit/fit_numbers.hpp"

#include <span>
#include <vector>

namespace culm::fit {

/// Spheres of the chain on which a search for chains of so many goes on.
[[nodiscard]] int searched_spheres(int spheres);

/// Y and β are such that the first mode stays as it is, and the recordings are shifted by what the
/// two chains still differ by at the fit. There both leave the same residuals, and a change of the
/// model changes these by nearly as much: what is left of the coarse chain's error is of second
/// order, as in a full approximation scheme (Brandt 1977, Math. Comp. 31:333-390).
class CoarseImage {
  public:
    /// All must outlive this. Where the chain is no finer, cannot be computed coarsely or something
    /// stands still, the image is the fit itself.
    CoarseImage(const Fit& fine, std::span<const ObservedRecording> recordings,
                const FitOptions& options);

    [[nodiscard]] bool is_coarser() const { return !recordings_.empty(); }
    [[nodiscard]] const Fit& fit() const { return is_coarser() ? fit_ : fine_; }
    [[nodiscard]] std::span<const ObservedRecording> recordings() const {
        return is_coarser() ? std::span<const ObservedRecording>(recordings_) : fine_recordings_;
    }
    /// `options` with the number of spheres of the image.
    [[nodiscard]] FitOptions options(FitOptions options) const;

    /// A fit of such chains in the numbers of the fine one, and the other way round.
    [[nodiscard]] Fit as_fine(Fit coarse) const;
    [[nodiscard]] Fit as_coarse(Fit fine) const;

  private:
    void match_first_mode();
    void add_part(std::size_t m, const run::Heartbeat& heartbeat);

    const Fit& fine_;
    std::span<const ObservedRecording> fine_recordings_;
    Fit fit_;
    std::vector<ObservedRecording> recordings_; ///< empty: the image is the fit itself
    double modulus_ratio_ = 1.0;                ///< Y of the coarse chain over that of the fine
    double decay_ratio_ = 1.0;                  ///< β over that of the same damping time
    double damping_ratio_ = 1.0;                ///< β over that of the fine chain
};

} // namespace culm::fit
