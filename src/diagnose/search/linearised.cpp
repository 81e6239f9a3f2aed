// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/evidence/estimated_starts.hpp"
#include "diagnose/search/prediction.hpp"
#include "fit/linear/scaled_solve.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/core.h>

namespace culm::diagnose {
namespace {

/// Have two stems the same points of the grid, with columns for the same sizes?
bool has_same_columns(const EffectColumns& one, const EffectColumns& other) {
    return std::ranges::equal(one.nodes, other.nodes, [](const auto& a, const auto& b) {
        return std::ranges::equal(a.columns, b.columns, [](const auto& left, const auto& right) {
            return left.parameter == right.parameter && left.is_certain == right.is_certain &&
                   (left.secant == 0.0) == (right.secant == 0.0);
        });
    });
}

/// As the first stem that shows the candidate; the sizes of the others are converted to its units.
EffectColumns first_columns(std::size_t candidate, const std::vector<const EffectView*>& views) {
    const auto found = std::ranges::find_if(
        views, [&](const EffectView* view) { return view->columns[candidate].failure.empty(); });
    return found == views.end() ? EffectColumns{"no stem shows it", {}, 0}
                                : (*found)->columns[candidate];
}

/// Gram matrix and overlap of columns, the shared ones last.
struct Normal {
    Eigen::MatrixXd gram;
    Eigen::VectorXd overlap;

    /// Without what the shared numbers imitate, whose Hessian is that of all stems.
    [[nodiscard]] Normal without_shared(const SharedMinimum& shared,
                                        const std::vector<Eigen::Index>& places) const {
        const Eigen::Index count = gram.cols() - std::ssize(places);
        Normal out{gram.topLeftCorner(count, count), overlap.head(count)};
        if (places.empty())
            return out;
        Eigen::MatrixXd across = Eigen::MatrixXd::Zero(shared.hessian.rows(), count);
        across(places, Eigen::all) = gram.bottomLeftCorner(std::ssize(places), count);
        out.gram -= across.transpose() * fit::ScaledSpectrum(shared.hessian).solve(across);
        return out;
    }
};

std::vector<Eigen::Index> places_of(const EffectView& view, const SharedMinimum& shared) {
    std::vector<Eigen::Index> places;
    for (const std::string& name : view.shared)
        places.push_back(shared.find(name));
    return places;
}

/// Gram matrix and overlap of a stem, with the residual at the common values of the shared numbers.
Normal normal_of(const EffectView& view, const SharedMinimum& shared, double variance) {
    Normal out{view.gram / variance, view.overlap / variance};
    const std::vector<Eigen::Index> places = places_of(view, shared);
    for (std::size_t k = 0; k < places.size(); ++k)
        out.overlap -= out.gram.col(view.column_count() + static_cast<Eigen::Index>(k)) *
                       (shared.at(places[k]) - view.shared_at[k]);
    return out;
}

/// Adds what a stem shows, in the common units.
void add_stem(const EffectView& view, const Normal& own, const SharedMinimum& shared,
              const RigView& common, Eigen::Index columns, Normal& sum) {
    std::vector<Eigen::Index> from;
    std::vector<Eigen::Index> to;
    std::vector<double> factors;
    Eigen::Index at = 0;
    for (std::size_t c = 0; c < view.columns.size(); ++c) {
        const EffectColumns& mine = view.columns[c];
        const EffectColumns& wanted = common.columns[c];
        if (!mine.failure.empty() || !has_same_columns(wanted, mine)) {
            at += wanted.column_count();
            continue;
        }
        Eigen::Index place = view.first_column(c, 0);
        for (std::size_t n = 0; n < mine.nodes.size(); ++n)
            for (std::size_t k = 0; k < mine.nodes[n].columns.size(); ++k) {
                from.push_back(place++);
                to.push_back(at++);
                factors.push_back(wanted.nodes[n].columns[k].deviation /
                                  mine.nodes[n].columns[k].deviation);
            }
    }
    const std::vector<Eigen::Index> places = places_of(view, shared);
    for (std::size_t k = 0; k < places.size(); ++k) {
        from.push_back(view.column_count() + static_cast<Eigen::Index>(k));
        to.push_back(columns + places[k]);
        factors.push_back(1.0);
    }
    const Eigen::Map<const Eigen::VectorXd> factor(factors.data(), std::ssize(factors));
    sum.gram(to, to) += factor.asDiagonal() * own.gram(from, from) * factor.asDiagonal();
    sum.overlap(to) += factor.asDiagonal() * own.overlap(from);
}

} // namespace

Linearised::Linearised(const Stems& stems, const Model& base, const std::vector<NoiseScale>& noise)
    : stems_(&stems), views_(stems.size()) {
    stems.options().report(fmt::format("computing the effects of {} candidates about {}",
                                       stems.options().candidates.size(),
                                       name_of(base.effects, stems)));
    compute_views(base);
    for (std::size_t s = 0; s < stems.size(); ++s) {
        const Normal own = normal_of(views_[s], base.shared, noise[s].mean_known())
                               .without_shared(base.shared, places_of(views_[s], base.shared));
        in_stem_.emplace_back(views_[s].columns, own.gram, own.overlap);
    }
    for (const std::string& rig : stems.rigs())
        rigs_.emplace(rig, view_of_rig(rig, base, noise));
}

void Linearised::compute_views(const Model& base) {
    const std::vector<std::size_t> fitted = stems_->fitted();
    const fit::SelectedEffects& candidates = stems_->options().candidates;
    const std::size_t parts = stems_->parts_per_stem(candidates.size());
    const auto begin = [&](std::size_t part) { return part * candidates.size() / parts; };
    std::vector<std::size_t> of; // each stem `parts` times
    std::vector<double> efforts;
    for (const std::size_t s : fitted)
        for (std::size_t part = 0; part < parts; ++part) {
            of.push_back(s);
            efforts.push_back(
                fit::relative_cost({candidates.begin() + std::ptrdiff_t(begin(part)),
                                    candidates.begin() + std::ptrdiff_t(begin(part + 1))}));
        }
    std::pair<std::size_t, fit::Fit> last{stems_->size(), {}}; // base of a stem, on this rank
    const auto base_of = [&](std::size_t s, const fit::FitOptions& options) -> const fit::Fit& {
        if (last.first != s)
            last = {s, base_fit(*stems_, s, base, options)};
        return last.second;
    };
    const auto columns_of = [&](std::size_t item, const fit::FitOptions& options) {
        const std::size_t part = item % parts;
        return columns_about(*stems_, of[item], base_of(of[item], options), begin(part),
                             begin(part + 1), options);
    };
    const auto view_with = [&](std::size_t s, std::vector<EffectColumns> columns,
                               const fit::FitOptions& options) {
        return view_of(std::move(columns),
                       shared_columns(base_of(s, options), (*stems_)[s].recordings,
                                      base.effects_of(s, *stems_).sharing));
    };
    std::vector<EffectView> found;
    if (parts == 1) {
        found = stems_->map(fitted, [&](std::size_t item, const fit::FitOptions& options) {
            return view_with(fitted[item], columns_of(item, options), options);
        });
    } else {
        auto columns = stems_->map(of, columns_of, efforts);
        found = stems_->map(fitted, [&](std::size_t item, const fit::FitOptions& options) {
            std::vector<EffectColumns> all;
            for (std::size_t part = 0; part < parts; ++part)
                std::ranges::move(columns[item * parts + part], std::back_inserter(all));
            return view_with(fitted[item], std::move(all), options);
        });
    }
    for (std::size_t k = 0; k < fitted.size(); ++k)
        views_[fitted[k]] = std::move(found[k]);
}

RigView Linearised::view_of_rig(const std::string& rig, const Model& base,
                                const std::vector<NoiseScale>& noise) const {
    const std::vector<std::size_t> on_rig = stems_->on_rig(rig);
    std::vector<const EffectView*> views;
    views.reserve(on_rig.size());
    for (const std::size_t s : on_rig)
        views.push_back(&views_[s]);
    RigView out{{}, {{}, {}, {}}};
    const fit::SelectedEffects& candidates = stems_->options().candidates;
    Eigen::Index columns = 0;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
        out.columns.push_back(candidates[c].effect->belongs_to == physics::BelongsTo::Rig
                                  ? first_columns(c, views)
                                  : EffectColumns{"it is of the stem", {}, 0});
        columns += out.columns.back().column_count();
    }
    const Eigen::Index count = columns + std::ssize(base.shared.names);
    Normal sum{Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count)};
    for (const std::size_t s : on_rig)
        add_stem(views_[s], normal_of(views_[s], base.shared, noise[s].mean_known()), base.shared,
                 out, columns, sum);
    std::vector<Eigen::Index> all;
    for (Eigen::Index k = 0; k < std::ssize(base.shared.names); ++k)
        all.push_back(k);
    Normal seen = sum.without_shared(base.shared, all);
    out.linear = LinearEvidence(out.columns, std::move(seen.gram), std::move(seen.overlap));
    return out;
}

ActingEffect Linearised::estimated(const std::string& rig, std::size_t candidate, std::size_t place,
                                   const PredictedGain& gain) const {
    const physics::SelectedEffect& effect = stems_->options().candidates[candidate];
    ActingEffect out = on_rig(effect, rig, *stems_);
    fit::StemModel model = stem_with(out, out.stems.front(), *stems_);
    place_effect(effect, rigs_.at(rig).columns[candidate], gain.points.front().effects[place], 0,
                 model);
    out.values = model.spec.effects.back().values;
    return out;
}

} // namespace culm::diagnose
