// SPDX-License-Identifier: BSD-3-Clause
// Several effects and known masses on one stem: their order does not matter.
#include "free_vibration.hpp"
#include "physics/effects/selection.hpp"
#include "run/case_model.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>

#include <gtest/gtest.h>

namespace culm::run {
namespace {

/// Appends the members of a struct that consists of `double`s.
template <class Part>
void append(const Part& part, std::vector<double>& numbers) {
    for (const double number :
         std::bit_cast<std::array<double, sizeof(Part) / sizeof(double)>>(part))
        numbers.push_back(number);
}

template <class Parts>
void append_all(const Parts& parts, std::vector<double>& numbers) {
    numbers.push_back(static_cast<double>(parts.size()));
    for (const auto& part : parts)
        append(part, numbers);
}

template <class Part>
void append_optional(const std::optional<Part>& part, std::vector<double>& numbers) {
    numbers.push_back(part ? 1.0 : 0.0);
    if (part)
        append(*part, numbers);
}

/// All numbers in the equations of motion and the observation of the case.
std::vector<double> numbers_of(const CaseSpec& spec) {
    const CaseModel model = case_model(spec);
    std::vector<double> numbers;
    append_all(model.chain.bonds, numbers);
    append_all(model.chain.spheres, numbers);
    append(model.chain.gravity, numbers);
    append_optional(model.chain.hinge, numbers);
    append_all(model.chain.branches, numbers);
    for (const physics::AirDrag<double>& drag : model.chain.air) {
        numbers.push_back(drag.coefficient);
        numbers.insert(numbers.end(), drag.shape.begin(), drag.shape.end());
    }
    append_optional(model.chain.bending, numbers);
    append_optional(model.chain.bending_loss, numbers);
    append_optional(model.chain.slip, numbers);
    append_optional(model.chain.air_mass, numbers);
    append_all(model.chain.straight_moments, numbers);
    append_optional(model.chain.base_motion, numbers);
    append_optional(model.chain.release, numbers);
    append(model.camera, numbers);
    return numbers;
}

physics::ActiveEffect usual(const physics::EffectPointer& effect, const CaseSpec& spec) {
    return physics::with_defaults(
        {effect, std::vector<std::optional<double>>(effect->parameters.size())}, spec.stem);
}

CaseSpec with_a_mass() {
    CaseSpec spec = coarse_stem();
    spec.stem.rectangle_depth = 2e-3; // so that all effects act on it
    spec.added_masses = {{0.8 * spec.stem.free_length(), 5e-6}};
    return spec;
}

TEST(TwoEffects, MakeTheSameModelInEitherOrder) {
    int pairs = 0;
    CaseSpec spec = with_a_mass();
    for (const physics::EffectPointer& first : physics::all_effects())
        for (const physics::EffectPointer& second : physics::all_effects()) {
            const std::vector<std::string> excluded = first->excludes;
            const std::vector<std::string> refused = second->excludes;
            if (first == second || std::ranges::find(excluded, second->name) != excluded.end() ||
                std::ranges::find(refused, first->name) != refused.end())
                continue;
            spec.effects = {usual(first, spec), usual(second, spec)};
            const std::vector<double> numbers = numbers_of(spec);
            std::swap(spec.effects.front(), spec.effects.back());
            EXPECT_EQ(numbers, numbers_of(spec)) << first->name << " and " << second->name;
            ++pairs;
        }
    EXPECT_GT(pairs, 300);
}

TEST(AddedMass, IsNotChangedByEffects) {
    for (const physics::EffectPointer& effect : physics::all_effects()) {
        CaseSpec spec = with_a_mass();
        spec.effects = {usual(effect, spec)};
        const CaseModel heavy = case_model(spec);
        const double mass = spec.added_masses.front().mass;
        spec.added_masses.clear();
        const CaseModel bare = case_model(spec);
        double more = 0.0;
        double before = 0.0;
        for (std::size_t i = 0; i < heavy.chain.spheres.size(); ++i) {
            before += bare.chain.spheres[bare.chain.spheres.size() == 1 ? 0 : i].mass;
            more += heavy.chain.spheres[i].mass;
        }
        // Rounding of a sum of nine masses.
        EXPECT_NEAR(more - before, mass, 1e-14 * more) << effect->name;
    }
}

} // namespace
} // namespace culm::run
