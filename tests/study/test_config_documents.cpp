// SPDX-License-Identifier: BSD-3-Clause
// docs/config.md says what the code accepts, and the example studies are valid.
#include "study/config.hpp"
#include "study/config_keys.hpp"
#include "study/design.hpp"
#include "study/design_check.hpp"

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

const std::filesystem::path source = CULM_SOURCE_DIR;

std::string content_of(const std::filesystem::path& file) {
    std::ifstream stream(file);
    EXPECT_TRUE(stream.good()) << file;
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

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

TEST(ConfigDocuments, TheKeyTablesAreThoseOfTheCode) {
    const std::string text = content_of(source / "docs/config.md");
    const std::string opening = "<!-- key tables: begin -->\n";
    const std::size_t begin = text.find(opening);
    const std::size_t end = text.find("\n<!-- key tables: end -->");
    ASSERT_NE(begin, std::string::npos);
    ASSERT_NE(end, std::string::npos);
    const std::string documented =
        text.substr(begin + opening.size(), end - begin - opening.size());
    const std::filesystem::path expected =
        std::filesystem::path(testing::TempDir()) / "config_key_tables.md";
    std::ofstream(expected) << config_key_tables();
    EXPECT_EQ(documented, config_key_tables())
        << "copy " << expected << " between the marks of docs/config.md";
}

TEST(ConfigDocuments, EveryKeyIsListedOnce) {
    std::set<std::string> seen;
    for (const ConfigKey& key : config_keys())
        EXPECT_TRUE(seen.insert(key.section + "." + key.key).second) << key.section << key.key;
}

TEST(ConfigDocuments, TheExamplesInTheTextAreValid) {
    const auto blocks = toml_blocks(content_of(source / "docs/config.md"));
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
