// SPDX-License-Identifier: BSD-3-Clause
// One line declares a key of a file, and one line a member of a result: everything else follows.
#include "core/describe.hpp"
#include "core/error.hpp"
#include "core/toml/key.hpp"
#include "core/wire.hpp"

#include <map>
#include <set>

#include <gtest/gtest.h>

namespace culm::core {
namespace {

struct Options {
    double length = 0.15;
    int spheres = 56;
};

KeyTable<Options> keys_without_spheres() {
    KeyTable<Options> keys("stem");
    keys.key("length_mm", &Options::length, {1.0, 1000.0}, "free length");
    return keys;
}

KeyTable<Options> keys_with_spheres() {
    KeyTable<Options> keys = keys_without_spheres();
    keys.key("spheres", &Options::spheres, {2.0, 10000.0}, "in the chain");
    return keys;
}

/// Reads a file with these keys; the message of a refusal, or "".
std::string read(const KeyTable<Options>& keys, const std::string& text, Options& options) {
    try {
        TomlDocument document(text, "a.toml");
        std::vector<std::string> names;
        for (const Key<Options>& key : keys.keys())
            names.push_back(key.name);
        document.root().declare(keys.name(), names);
        std::set<std::string> wrong;
        keys.read(document.root().table(keys.name()), options, wrong);
        document.finish();
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

std::map<std::string, std::string, std::less<>> identity(const KeyTable<Options>& keys,
                                                         const Options& options) {
    std::map<std::string, std::string, std::less<>> lines;
    keys.add_identity(options, lines);
    return lines;
}

TEST(OneLineForAKey, MakesTheReaderAcceptItWithinItsRange) {
    Options options;
    EXPECT_EQ(read(keys_without_spheres(), "[stem]\nspheres = 20\n", options),
              "a.toml:2: stem.spheres = 20: unknown key; allowed: length_mm");
    EXPECT_EQ(read(keys_with_spheres(), "[stem]\nspheres = 20\nlength_mm = 200\n", options), "");
    EXPECT_EQ(options.spheres, 20);
    EXPECT_EQ(options.length, 0.2); // SI
    EXPECT_EQ(read(keys_with_spheres(), "[stem]\nspheres = 1\n", options),
              "a.toml:2: stem.spheres = 1: must be a whole number in [2, 10000]");
}

TEST(OneLineForAKey, MakesTheHintsKnowIt) {
    Options options;
    EXPECT_EQ(read(keys_with_spheres(), "[stem]\nsphres = 20\n", options),
              "a.toml:2: stem.sphres = 20: unknown key (did you mean spheres?)");
    EXPECT_EQ(read(keys_with_spheres(), "spheres = 20\n", options),
              "a.toml:1: spheres = 20: unknown key: spheres belongs into [stem]");
    EXPECT_EQ(read(keys_with_spheres(), "[stem]\nlength_cm = 20\n", options),
              "a.toml:2: stem.length_cm = 20: unknown key: the unit is mm (write length_mm = 200)");
}

std::vector<KeyDescription> descriptions_of(const KeyTable<Options>& table) {
    return {table.keys().begin(), table.keys().end()};
}

TEST(OneLineForAKey, AddsItToTheReferenceWithItsDefault) {
    const std::string before = markdown_tables(descriptions_of(keys_without_spheres()));
    const std::string after = markdown_tables(descriptions_of(keys_with_spheres()));
    EXPECT_EQ(after, before + "| `spheres` | – | 56 | a whole number in [2, 10000] | in the chain "
                              "|\n");
    EXPECT_NE(before.find("| `length_mm` | mm | 150 | a number in [1, 1000] mm | free length |\n"),
              std::string::npos);
}

TEST(OneLineForAKey, AddsItToTheIdentity) {
    Options options;
    EXPECT_FALSE(identity(keys_without_spheres(), options).contains("stem.spheres"));
    EXPECT_EQ(identity(keys_with_spheres(), options).at("stem.spheres"), "56");
    options.spheres = 20;
    EXPECT_EQ(identity(keys_with_spheres(), options).at("stem.spheres"), "20");
}

struct Tip {
    double deflection = 0.0; ///< m
    bool is_seen = false;
    friend bool operator==(const Tip&, const Tip&) = default;
};

template <class To>
void describe(To& to, const Tip& tip) {
    to("deflection_mm", tip.deflection, "at the release");
    to("seen", tip.is_seen);
}

struct Stem {
    std::string id;
    std::vector<Tip> tips;
    friend bool operator==(const Stem&, const Stem&) = default;
};

template <class To>
void describe(To& to, const Stem& stem) {
    to("id", stem.id);
    to("tips", stem.tips);
    to("tip_count", [&] { return stem.tips.size(); });
    to.object("state", [&] { to("empty", [&] { return stem.tips.empty(); }); });
}

TEST(OneLineForAMember, GivesItsJsonInTheUnitOfTheKey) {
    EXPECT_EQ(json_of(Stem{"S01", {{0.0025, true}}}).dump(),
              R"({"id":"S01","state":{"empty":false},"tip_count":1,)"
              R"("tips":[{"deflection_mm":2.5,"seen":true}]})");
}

TEST(OneLineForAMember, GivesItsSchema) {
    const nlohmann::json schema = schema_of<Stem>();
    EXPECT_EQ(schema["required"], (std::vector<std::string>{"id", "tips", "tip_count", "state"}));
    EXPECT_EQ(schema["additionalProperties"], false);
    const nlohmann::json& tip = schema["properties"]["tips"]["items"];
    EXPECT_EQ(tip["properties"]["deflection_mm"].dump(),
              R"({"description":"at the release","type":["number","null"]})");
    EXPECT_EQ(tip["properties"]["seen"].dump(), R"({"type":"boolean"})");
    EXPECT_EQ(schema["properties"]["tip_count"]["type"], "integer");
}

TEST(OneLineForAMember, LetsItTravelBetweenRanks) {
    const Stem stem{"S01", {{0.0025, true}, {1.0 / 3.0, false}}};
    EXPECT_EQ(decoded<Stem>(encoded(stem)), stem);
}

struct Optional {
    std::optional<double> angle;
    bool has_phase = false;
};

template <class To>
void describe(To& to, const Optional& of) {
    to("angle_rad", of.angle);
    to.when(of.has_phase, [&] { to("phase_rad", 1.0); });
    to.maybe("fit", of.has_phase, [&] { to("rmse_mm", 0.001); });
}

TEST(Description, WritesNullOrNothingForWhatIsMissing) {
    EXPECT_EQ(json_of(Optional{}).dump(), R"({"angle_rad":null,"fit":null})");
    EXPECT_EQ(json_of(Optional{0.5, true}).dump(),
              R"({"angle_rad":0.5,"fit":{"rmse_mm":1.0},"phase_rad":1.0})");
    const nlohmann::json schema = schema_of<Optional>();
    EXPECT_EQ(schema["required"], (std::vector<std::string>{"angle_rad", "fit"}));
    EXPECT_EQ(schema["properties"]["fit"]["type"].dump(), R"(["object","null"])");
}

} // namespace
} // namespace culm::core
