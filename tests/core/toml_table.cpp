// SPDX-License-Identifier: BSD-3-Clause
// Error messages of the reader of TOML files.
#include "core/error.hpp"
#include "core/toml/table.hpp"

#include <functional>

#include <gtest/gtest.h>

namespace culm::core {
namespace {

/// The message with which `read` refuses a text, or "accepted".
std::string refusal(const std::string& text, const std::function<void(const TomlTable&)>& read) {
    try {
        TomlDocument document(text, "a.toml");
        read(document.root());
        document.finish();
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

/// [stem] length_mm, [measurement] reading, [[mark]] height_mm.
std::string refusal(const std::string& text) {
    return refusal(text, [](const TomlTable& root) {
        static_cast<void>(root.table("stem").quantity("length_mm", {1e-3, 100.0}));
        const std::vector<std::string> words{"row", "material"};
        static_cast<void>(root.table("measurement").word("reading", words));
        static_cast<void>(root.absent("mark").quantity("height_mm", {0.0, 100.0}));
        for (const TomlTable& mark : root.tables("mark"))
            static_cast<void>(mark.quantity("height_mm", {0.0, 100.0}));
    });
}

TEST(TomlTable, SendsAKeyToTheTableItBelongsTo) {
    EXPECT_EQ(refusal("[stem]\nlength_mm = 3\nreading = \"row\"\n"),
              "a.toml:3: stem.reading = \"row\": unknown key: reading belongs into [measurement]");
    EXPECT_EQ(refusal("reading = \"row\"\n[stem]\nlength_mm = 3\n"),
              "a.toml:1: reading = \"row\": unknown key: reading belongs into [measurement]");
    EXPECT_EQ(refusal("[[mark]]\nheight_mm = 1\n[[mark]]\nlength_m = 1\n"),
              "a.toml:4: mark.length_m = 1: unknown key: length_m belongs into [stem]");
    EXPECT_EQ(refusal("[stem]\nheight_mm = 1\n"),
              "a.toml:2: stem.height_mm = 1: unknown key: height_mm belongs into [[mark]]");
    EXPECT_EQ(
        refusal("[stem.mark]\nheight_mm = 1\n"),
        "a.toml:1: stem.mark: unknown table: mark belongs into the top level: write [[mark]]");
}

TEST(TomlTable, KnowsTheLastDigitThatIsWritten) {
    const auto digit = [](const std::string& text, const std::string& key = "mass_g") {
        TomlDocument document(text, "a.toml");
        return document.root().last_digit_of(key);
    };
    EXPECT_EQ(digit("mass_g = 0.050"), 1e-6);
    EXPECT_EQ(digit("mass_g = 0.05 # 0.0512"), 1e-5);
    EXPECT_EQ(digit("mass_g = 52\n"), 1e-3);
    EXPECT_EQ(digit("id = \"µ\"\n\"mass_kg\"=+1_0.50E-3"), 1e-5);
    EXPECT_EQ(digit("mass_kg = 2e+1"), 10.0);
    EXPECT_EQ(digit("mass_g = \"heavy\""), 0.0);
    EXPECT_EQ(digit("length_mm = 1.0"), 0.0);
    EXPECT_EQ(digit("mass_mm = 1.00", "mass_mm"), 1e-5);
}

TEST(TomlTable, NamesTheNearestKeyHereThenElsewhere) {
    EXPECT_EQ(refusal("[stem]\nlenght_mm = 3\n"),
              "a.toml:2: stem.lenght_mm = 3: unknown key (did you mean length_mm?)");
    EXPECT_EQ(refusal("[stem]\nlength_cm = 3\n"),
              "a.toml:2: stem.length_cm = 3: unknown key: the unit is mm (write length_mm = 30)");
    EXPECT_EQ(
        refusal("[stem]\nreadin = \"row\"\n"),
        "a.toml:2: stem.readin = \"row\": unknown key (did you mean reading in [measurement]?)");
    EXPECT_EQ(refusal("[stems]\nlength_mm = 3\n"),
              "a.toml:1: stems: unknown table (did you mean stem?)");
    EXPECT_EQ(refusal("[stem]\noperator = \"me\"\n"),
              "a.toml:2: stem.operator = \"me\": unknown key; allowed: length_mm");
}

TEST(TomlTable, ReportsLineValueAndAllowedValues) {
    EXPECT_EQ(refusal("[stem]\nlength_mm = 0.5\n"),
              "a.toml:2: stem.length_mm = 0.5: must be a number in [1, 100000]");
    EXPECT_EQ(refusal("[stem]\nlength_m = nan\n"),
              "a.toml:2: stem.length_m = nan: must be a number in [0.001, 100]");
    // No double equals it, so toml++ returns none.
    EXPECT_EQ(refusal("[stem]\nlength_mm = 9223372036854775807\n"),
              "a.toml:2: stem.length_mm = 9223372036854775807: must be a number in [1, 100000]");
    EXPECT_EQ(refusal("[stem]\nlength_mm = \"156 ± 0.4\"\n"),
              "a.toml:2: stem.length_mm = \"156 ± 0.4\": must be a number without quotes; a bare ± "
              "does not say what it means: give the standard uncertainty in a separate key");
    EXPECT_EQ(refusal("[measurement]\nreading = \"rows\"\n"),
              "a.toml:2: measurement.reading = \"rows\": must be \"row\" or \"material\" (did you "
              "mean \"row\"?)");
    EXPECT_EQ(refusal("stem = 3\n"), "a.toml:1: stem = 3: must be a table: write [stem]");
    EXPECT_EQ(refusal("[stem]\nlength_mm = 157,0\n").find("a.toml:2: not valid TOML: "), 0U);
    EXPECT_NE(refusal("[stem]\nlength_mm = 157,0\n").find("(column 16) (a decimal comma?"),
              std::string::npos)
        << refusal("[stem]\nlength_mm = 157,0\n");
}

TEST(TomlTable, ReportsATableOnceHoweverOftenItIsReached) {
    EXPECT_EQ(refusal("[stem]\nvolume = 1\n",
                      [](const TomlTable& root) {
                          static_cast<void>(root.table("stem").number("a", {0.0, 1.0}));
                          static_cast<void>(root.table("stem").number("b", {0.0, 1.0}));
                      }),
              "a.toml:2: stem.volume = 1: unknown key; allowed: a, b");
}

} // namespace
} // namespace culm::core
