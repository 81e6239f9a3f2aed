// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target: a user's effect. The first byte chooses: the text of an effect's TOML file, a list
// of effects as on the command line, or a formula of one of the three kinds.
#include "fuzz/fuzz_input.hpp"
#include "physics/effects/selection.hpp"
#include "physics/effects/user_effect.hpp"
#include "study/config/study_effects.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace culm;
    if (size == 0)
        return 0;
    const std::string text = fuzz::text_of(data + 1, size - 1);
    fuzz::may_refuse([&] {
        switch (data[0] % 5) {
        case 0:
            static_cast<void>(study::read_effect_file(fuzz::write("effect.toml", text)));
            break;
        case 1:
            static_cast<void>(
                physics::parse_effects(text, [](const std::string&) -> physics::EffectPointer {
                    throw core::InputError("there are no files here");
                }));
            break;
        default: {
            physics::UserEffectText effect;
            effect.name = "fuzzed";
            effect.kind = static_cast<physics::UserLawKind>(data[0] % 5 - 2);
            effect.formula = text;
            for (const char* name : {"a", "b"}) {
                physics::EffectParameter parameter;
                parameter.name = name;
                parameter.default_value = 0.5;
                parameter.lower = -1.0;
                parameter.upper = 2.0;
                effect.parameters.push_back(parameter);
            }
            static_cast<void>(physics::make_user_effect(std::move(effect)));
        }
        }
    });
    return 0;
}
