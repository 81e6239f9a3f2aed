// SPDX-License-Identifier: BSD-3-Clause
// Feeds every file of a folder to a fuzz target, for builds without libFuzzer.
#include "fuzz/fuzz_input.hpp"

#include <algorithm>
#include <exception>
#include <iostream>
#include <iterator>
#include <span>
#include <vector>

int main(int argc, char** argv) {
    namespace fs = std::filesystem;
    const std::span<char*> arguments(argv, static_cast<std::size_t>(argc));
    if (arguments.size() != 2) {
        std::cerr << "usage: replay_TARGET FOLDER\n";
        return 2;
    }
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(arguments[1]))
        files.push_back(entry.path());
    std::ranges::sort(files);
    for (const fs::path& file : files) {
        std::ifstream stream(file, std::ios::binary);
        const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
        try {
            static_cast<void>(LLVMFuzzerTestOneInput(
                reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
        } catch (const std::exception& error) {
            std::cerr << file.string() << ": " << error.what() << '\n';
            return 1;
        }
    }
    std::cout << files.size() << " inputs\n";
    return files.empty() ? 1 : 0; // an empty corpus tests nothing
}
