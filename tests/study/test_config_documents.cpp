// SPDX-License-Identifier: BSD-3-Clause
// The reference of study files agrees with the reader, and the example studies are valid.
#include "study/config/keys.hpp"
#include "study/config/study_config.hpp"
#include "study/design/design.hpp"
#include "study/execute/plan.hpp"
#include "support/file_content.hpp"

#include <filesystem>
#include <set>

#include <gtest/gtest.h>
#include <toml++/toml.h>

namespace culm::study {
namespace {

const std::filesystem::path source = CULM_SOURCE_DIR;

/// The ```toml blocks of a Markdown text.
std::vector<std::string> toml_blocks(const std::string& text) {
    std::vector<std::string> blocks;
    const std::string opening = "```toml\n";
    for (std::size_t at = text.find(opening); at != std::string::npos;
         at = text.find(opening, at + 1)) {
        const std::size_t begin = at + opening.size();
        blocks.push_back(text.substr(begin, text.find("```", begin) - begin));
    }
    return blocks;
}

/// A study file to which a line with this key may be appended.
std::string file_for(const KeyDescription& key) {
    if (key.table == "timestep")
        return "[study]\nkind = \"timestep\"\n[timestep]\nfractions = [0.5]\n";
    return "[" + key.table + "]\n";
}

bool is_toml_value(const std::string& text) {
    try {
        return !toml::parse("x = " + text).empty();
    } catch (const toml::parse_error&) {
        return false; // a description such as "the whole record"
    }
}

TEST(ConfigDocuments, EveryDefaultIsThatOfTheReader) {
    int compared = 0;
    for (const KeyDescription& key : config_keys()) {
        // Keys of a factor or of one type of design are not valid without it.
        if (!is_toml_value(key.default_text) || key.table.starts_with("factors") ||
            key.name == "scrambling")
            continue;
        ++compared;
        const std::string text = file_for(key);
        const std::string line = key.name + " = " + key.default_text + "\n";
        EXPECT_EQ(parse_config(text + line, "with").identity(),
                  parse_config(text, "without").identity())
            << key.table << ": " << line;
    }
    EXPECT_GT(compared, 25);
}

TEST(ConfigDocuments, EveryKeyIsListedOnce) {
    std::set<std::string> seen;
    for (const KeyDescription& key : config_keys())
        EXPECT_TRUE(seen.insert(key.table + "." + key.name).second) << key.table << key.name;
}

TEST(ConfigDocuments, TheExamplesInTheTextAreValid) {
    const auto blocks = toml_blocks(tests::content_of(source / "docs/config.md"));
    ASSERT_GE(blocks.size(), 4U);
    for (const std::string& block : blocks) {
        const StudyConfig config = parse_config(block, "docs/config.md");
        EXPECT_NO_THROW(check_points(config, make_design(config))) << block;
    }
}

TEST(ConfigDocuments, EveryExampleStudyIsValidAtEveryPoint) {
    int examples = 0;
    for (const auto& entry : std::filesystem::directory_iterator(source / "config")) {
        if (entry.path().extension() != ".toml")
            continue;
        ++examples;
        const StudyConfig config = load_config(entry.path());
        EXPECT_EQ(config.name, entry.path().stem().string());
        EXPECT_NO_THROW(check_points(config, make_design(config))) << entry.path();
    }
    EXPECT_GE(examples, 4);
}

TEST(ConfigDocuments, ThePublishedDesignHas80Points) {
    for (const char* name : {"config/schramm2019.toml", "config/schramm2019-explicit.toml"}) {
        const StudyConfig config = load_config(source / name);
        const Design design = make_design(config);
        ASSERT_EQ(design.point_count(), 80);
        const run::CaseSpec first = case_of_point(config, design, 0);
        EXPECT_EQ(first.stem.bond_damping, 25.0);
        EXPECT_EQ(first.stem.bond_youngs_modulus, 1e9);
        const run::CaseSpec last = case_of_point(config, design, 79);
        EXPECT_EQ(last.stem.bond_damping, 200.0);
        EXPECT_EQ(last.stem.bond_youngs_modulus, 10e9);
        EXPECT_EQ(last.sample_count(), 2001U);
    }
}

} // namespace
} // namespace culm::study
