// SPDX-License-Identifier: BSD-3-Clause
// What the diagnosis says of recordings whose hidden effects are known, once noise that is not
// white or not Gaussian is added to their own.
//
//   bench_noisy_recordings FAMILY SEED FILE FOLDER...
//
// FAMILY: one of noise_families in reading_noise.hpp. A FOLDER is a measurement, or holds several,
// named as "T2-quadratic_drag", "T7-quadratic_drag+clamp_compliance", "T1-null": the truth. The
// added noise has the size that the recording states for its own; the recording then states both
// together, √2 of it. Adds every answer to FILE, prints it with what it is worth beside the truth
// (Grade in diagnosis_score.hpp), then how often each grade was given. The noise follows from
// family, seed and the folder's name alone.
#include "bench/diagnosis_score.hpp"
#include "bench/diagnosis_summary.hpp"
#include "bench/reading_noise.hpp"
#include "bench/result_file.hpp"
#include "core/error.hpp"
#include "measure/folder/measurement_folder.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace {

using namespace culm;
using nlohmann::json;

/// What is hidden in the recording of a folder of this name. Throws core::InputError if the name
/// does not tell.
beam::RandomCase truth_of(const std::string& folder) {
    const std::vector<std::string> known = beam::library_effects();
    beam::RandomCase truth;
    std::size_t before = folder.find('-');
    if (before != std::string::npos && folder.substr(before + 1) == "null")
        return truth;
    truth.kind = beam::CaseKind::Single;
    do {
        const std::size_t first = before == std::string::npos ? 0 : before + 1;
        before = folder.find('+', first);
        const std::string name = folder.substr(first, before - first);
        if (std::ranges::find(known, name) == known.end())
            throw core::InputError(fmt::format(
                "{}: \"{}\" is no effect; a folder is named as \"T1-null\" or \"T2-gravity\"",
                folder, name));
        truth.spec.effects.push_back({name, {}});
    } while (before != std::string::npos);
    return truth;
}

std::uint64_t number_of(const std::string& folder, std::uint64_t seed) {
    std::vector<std::uint64_t> words{seed};
    words.insert(words.end(), folder.begin(), folder.end());
    std::seed_seq mixed(words.begin(), words.end());
    std::array<std::uint32_t, 2> halves{};
    mixed.generate(halves.begin(), halves.end());
    return (std::uint64_t{halves[0]} << 32U) + halves[1];
}

/// The recording with noise of the family beside its own; it states the size of both together.
measure::Measurement noisier(measure::Measurement measurement, const std::string& family,
                             std::uint64_t number) {
    if (!measurement.noise)
        throw core::InputError(
            fmt::format("{}: the recording states no noise_mm", measurement.stem.id));
    const double size = *measurement.noise;
    bench::Noise(family, number).add(size, measurement);
    measurement.noise = std::hypot(size, size);
    for (std::vector<double>* sizes :
         {&measurement.noise_by_height, &measurement.reading_uncertainties})
        for (double& own : *sizes)
            own = std::hypot(own, size);
    return measurement;
}

bench::Outcome outcome_of(const diagnose::Diagnosis& found) {
    bench::Outcome outcome;
    outcome.verdict = to_string(found.conclusion);
    outcome.effects = found.effects;
    outcome.ties = bench::ties_of(found);
    return outcome;
}

json case_of(const measure::Measurement& recording, const std::string& folder,
             const std::string& family, std::uint64_t seed) {
    const beam::RandomCase truth = truth_of(folder);
    const measure::Measurement noisy = noisier(recording, family, number_of(folder, seed));
    json out{{"stated_noise_mm", 1e3 * *noisy.noise}};
    diagnose::DiagnosisOptions options;
    const auto start = std::chrono::steady_clock::now();
    try {
        const diagnose::Diagnosis found = diagnose::diagnose(std::span(&noisy, 1), options);
        const bench::Outcome outcome = outcome_of(found);
        out.update(bench::diagnosis_summary(found));
        out["ties"] = outcome.ties;
        out["grade"] = to_string(grade(truth, outcome));
    } catch (const std::exception& error) {
        out["answer"] = "failed";
        out["reason"] = error.what();
        out["grade"] = to_string(bench::Grade::Failed);
    }
    out["seconds"] =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return out;
}

void print(const json& out) {
    std::string ties;
    for (const json& tie : out.value("ties", json::array()))
        ties += fmt::format(" ({})", fmt::join(tie.get<std::vector<std::string>>(), " or "));
    fmt::print("{} {} {}: {} | {}{} | χ² {:.3f} to {:.3f} | {} | {} | {}\n",
               out["family"].get<std::string>(), out["seed"].get<std::uint64_t>(),
               out["folder"].get<std::string>(), out["grade"].get<std::string>(),
               out["answer"].get<std::string>(), ties, out.value("baseline_reduced_chi2", 0.0),
               out.value("final_reduced_chi2", 0.0), out.value("tests", ""), out.value("noise", ""),
               out["reason"].get<std::string>());
    std::fflush(stdout);
}

void diagnose_all(const std::string& family, std::uint64_t seed, const std::string& file,
                  const std::vector<std::string>& folders) {
    if (std::ranges::find(bench::noise_families, family) == bench::noise_families.end())
        throw core::InputError(fmt::format("\"{}\" is no family of noise; there are {}", family,
                                           fmt::join(bench::noise_families, ", ")));
    const measure::MeasurementSet set = measure::read_measurements(folders);
    std::map<std::string, const measure::Measurement*> by_folder;
    std::vector<json> keys;
    for (std::size_t m = 0; m < set.measurements.size(); ++m) {
        const std::string folder = (set.folders[m] / "").parent_path().filename().string();
        by_folder[folder] = &set.measurements[m];
        keys.push_back({{"folder", folder}, {"family", family}, {"seed", seed}});
    }
    bench::ResultFile results(file);
    results.add(
        keys,
        [&](const json& key) {
            return case_of(*by_folder.at(key["folder"]), key["folder"], family, seed);
        },
        print);
    std::map<std::string, int> grades;
    for (const json& each : results.cases())
        if (each["family"] == family)
            ++grades[each["grade"].get<std::string>()];
    for (const auto& [grade, times] : grades)
        fmt::print("{}: {}\n", grade, times);
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 5) {
        fmt::print(stderr, "usage: bench_noisy_recordings FAMILY SEED FILE FOLDER...\n");
        return 2;
    }
    try {
        diagnose_all(argv[1], std::strtoull(argv[2], nullptr, 10), argv[3],
                     {argv + 4, argv + argc});
    } catch (const core::InputError& error) {
        fmt::print(stderr, "{}\n", error.what());
        return 2;
    }
    return 0;
}
