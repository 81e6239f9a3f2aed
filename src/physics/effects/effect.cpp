// SPDX-License-Identifier: BSD-3-Clause
#include "physics/effects/effect.hpp"

#include <utility>

namespace culm::physics {

std::string_view to_string(FittedAs fitted_as) {
    switch (fitted_as) {
    case FittedAs::Itself:
        return "as it is";
    case FittedAs::Logarithm:
        return "as its logarithm";
    case FittedAs::Inverse:
        return "as its inverse";
    }
    return "as it is";
}

std::string_view to_string(Family family) {
    switch (family) {
    case Family::MaterialDamping:
        return "material damping";
    case Family::Air:
        return "air";
    case Family::Clamp:
        return "clamp";
    case Family::StemGeometry:
        return "stem geometry";
    case Family::SupportAndCamera:
        return "support and camera";
    case Family::Release:
        return "release";
    case Family::Weight:
        return "weight";
    case Family::Own:
        return "own law";
    }
    return "own law";
}

bool is_one_law(Family family) {
    return family == Family::MaterialDamping || family == Family::Air;
}

namespace {

class CardEffect final : public Effect {
  public:
    CardEffect(EffectCard card, ApplyEffect how, SuitParameters suit)
        : card_(std::move(card)), apply_(how), suit_(suit) {}

    [[nodiscard]] std::string name() const override { return card_.name; }
    [[nodiscard]] std::string summary() const override { return card_.summary; }
    [[nodiscard]] std::string law() const override { return card_.law; }
    [[nodiscard]] std::string source() const override { return card_.source; }
    [[nodiscard]] std::string signature() const override { return card_.signature; }
    [[nodiscard]] std::string remedy() const override { return card_.remedy; }
    [[nodiscard]] std::string energy() const override { return card_.energy; }
    [[nodiscard]] std::vector<EffectParameter> parameters() const override {
        return card_.parameters;
    }
    [[nodiscard]] std::vector<EffectParameter>
    parameters_for(const StemParameters<double>& stem) const override {
        std::vector<EffectParameter> parameters = card_.parameters;
        if (suit_ != nullptr)
            suit_(stem, parameters);
        return parameters;
    }
    [[nodiscard]] std::vector<std::string> excludes() const override { return card_.excludes; }
    [[nodiscard]] int dimensions() const override { return card_.dimensions; }
    [[nodiscard]] Family family() const override { return card_.family; }
    [[nodiscard]] BelongsTo belongs_to() const override { return card_.belongs_to; }
    [[nodiscard]] std::vector<RevealingExperiment> revealed_by() const override {
        return card_.revealed_by;
    }
    [[nodiscard]] bool spans_the_stem() const override { return card_.spans_the_stem; }
    [[nodiscard]] bool is_of_the_release() const override { return card_.is_of_the_release; }
    [[nodiscard]] bool is_of_the_camera() const override { return card_.is_of_the_camera; }
    [[nodiscard]] std::vector<PlanarPart>
    planar_parts(std::span<const double> values) const override {
        return card_.planar_parts == nullptr ? std::vector<PlanarPart>()
                                             : card_.planar_parts(values);
    }
    [[nodiscard]] std::vector<SpecialCase> special_cases() const override {
        return card_.special_cases;
    }
    void apply(std::span<const double> values, EffectTarget& target) const override {
        apply_(values, target);
    }

  private:
    EffectCard card_;
    ApplyEffect apply_;
    SuitParameters suit_;
};

} // namespace

EffectPointer make_effect(EffectCard card, ApplyEffect apply, SuitParameters suit) {
    return std::make_shared<CardEffect>(std::move(card), apply, suit);
}

} // namespace culm::physics
