// SPDX-License-Identifier: BSD-3-Clause
// bash reads a quoted word as the original text, whatever its bytes are.
#include "cluster/batch_system.hpp"

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::cluster {
namespace {

/// The argument that a program receives when bash calls it with this word.
std::string as_bash_reads(const std::string& word) {
    // In single quotes for the shell that starts bash.
    std::string script;
    for (const char c : "printf %s " + word + "; printf .")
        script += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return program_output("bash -c '" + script + "'", std::chrono::seconds(20));
}

std::string byte(int value) {
    return std::string(1, static_cast<char>(value));
}

TEST(ShellWord, KeepsPlainPathsReadable) {
    EXPECT_EQ(shell_word("/home/a_b/study-1.toml"), "/home/a_b/study-1.toml");
    EXPECT_EQ(shell_word("my study"), "'my study'");
    EXPECT_EQ(shell_word(""), "''");
}

TEST(ShellWord, IsReadByBashAsTheSameText) {
    const std::vector<std::string> nasty = {"",         " ",
                                            "a b",      "it's",
                                            "\"",       "$HOME",
                                            "`id`",     "$(id)",
                                            "a;b",      "a\nb",
                                            "\n",       "\\",
                                            "\\n",      "a\\'b",
                                            "~",        "*",
                                            "!!",       "#x",
                                            "-n",       "a\tb",
                                            "{a,b}",    "a=b",
                                            "\x7f",     "é ü",
                                            "\xff\xfe", "'\n#SBATCH --hold",
                                            "$'x'",     "a'\\''b",
                                            "a\r\nb",   "&& rm"};
    for (const std::string& text : nasty)
        EXPECT_EQ(as_bash_reads(shell_word(text)), text + ".") << shell_word(text);
}

TEST(ShellWord, PreservesEveryByte) {
    std::string all;
    for (int value = 1; value < 256; ++value)
        all += byte(value);
    EXPECT_EQ(as_bash_reads(shell_word(all)), all + ".");
    // And where a digit follows an escaped character.
    EXPECT_EQ(as_bash_reads(shell_word("\n7\x01"
                                       "1")),
              "\n7\x01"
              "1.");
}

TEST(ShellWord, PreservesRandomBytes) {
    std::mt19937 random(5);
    std::uniform_int_distribution<int> any(1, 255);
    for (int k = 0; k < 50; ++k) {
        std::string text;
        for (int length = any(random) % 40; length > 0; --length)
            text += byte(any(random));
        EXPECT_EQ(as_bash_reads(shell_word(text)), text + ".") << shell_word(text);
    }
}

} // namespace
} // namespace culm::cluster
