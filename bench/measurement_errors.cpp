// SPDX-License-Identifier: BSD-3-Clause
// What the diagnosis says of recordings in which only the measurement errs: noise that is not white
// or Gaussian, inputs that are misstated, chains of other numbers of spheres.
//
//   bench_measurement_errors FAMILY FIRST COUNT FILE [SPHERES]
//
// FAMILY: white, ar05, ar09, ar05_common, ar09_common, student, outliers, quantised (nothing is
// missing, inputs exact), inputs (nothing is missing, inputs misstated), pair (the same stem bare
// and with a known mass of 0.6 times its own at the tip, inputs misstated), drag (quadratic drag,
// inputs misstated). Recordings are those of the beam generator. Adds the cases to FILE, prints how
// often each answer was given. The truth of a case follows from its number and family alone.
#include "bench/diagnosis_summary.hpp"
#include "bench/misstated_inputs.hpp"
#include "bench/reading_noise.hpp"
#include "bench/result_file.hpp"
#include "diagnose/diagnosis.hpp"
#include "tests/beam_generator/random_case.hpp"

#include <chrono>
#include <cstdlib>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace {

using namespace culm;
using nlohmann::json;

/// By how many standard uncertainties the input of this name errs in this case. The name decides,
/// not the order: the loaded recording has an input that the bare one has not, and what the rig and
/// the specimen share must err alike in both.
double error_of(const std::string& input, std::uint64_t number) {
    std::seed_seq seed(input.begin(), input.end());
    std::uint32_t of_name = 0;
    seed.generate(&of_name, &of_name + 1);
    std::mt19937_64 dice(0xe4404000 + number + (std::uint64_t{of_name} << 32U));
    return std::normal_distribution<double>()(dice);
}

std::vector<measure::Measurement> recordings_of(const std::string& family, std::uint64_t number,
                                                int spheres) {
    constexpr std::uint64_t seed = 0x20e4404;
    beam::RecordingSpec spec = beam::random_case(seed, beam::CaseKind::Null, number).spec;
    const double noise = spec.errors.noise;
    spec.errors = {};
    const bool errs = family == "inputs" || family == "pair" || family == "drag";
    if (family == "drag")
        spec.effects = {{"quadratic_drag", {{"drag_coefficient", 1.2}}}};
    const std::string owner(1, 'A');
    std::vector<measure::Measurement> recordings;
    const int count = family == "pair" ? 2 : 1;
    for (int k = 0; k < count; ++k) {
        const double mass = 0.6 * spec.stem.mass_per_length() * spec.stem.length;
        spec.id = fmt::format("{}", k == 0 ? "bare" : "loaded");
        if (k == 1) {
            spec.effects = {{"tip_mass", {{"mass_kg", mass}}}};
            spec.duration *= 2.0;
        }
        measure::Measurement measurement = beam::record(spec);
        measurement.noise = noise;
        measurement.specimen = owner;
        measurement.rig = owner;
        if (k == 1)
            measurement.stem.added_masses = {{spec.stem.length, mass, {}}};
        bench::Noise(family, 0x401500 + 2 * number + static_cast<std::uint64_t>(k))
            .add(noise, measurement);
        measurement.stem.spheres = spheres;
        if (errs)
            measurement =
                bench::misstated(std::move(measurement), [=](const fit::StatedInput& input) {
                    return error_of(input.name, number);
                });
        recordings.push_back(std::move(measurement));
    }
    return recordings;
}

json case_of(const std::string& family, std::uint64_t number, int spheres) {
    const std::vector<measure::Measurement> recordings = recordings_of(family, number, spheres);
    json out;
    diagnose::DiagnosisOptions options;
    const auto start = std::chrono::steady_clock::now();
    try {
        out.update(bench::diagnosis_summary(diagnose::diagnose(recordings, options)));
    } catch (const std::exception& error) {
        out["answer"] = "failed";
        out["reason"] = error.what();
    }
    out["seconds"] =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return out;
}

void print(const json& each) {
    fmt::print("{} {}: {} | {} | {}\n", each["family"].get<std::string>(),
               each["number"].get<std::uint64_t>(), each["answer"].get<std::string>(),
               each.value("tests", ""), each.value("noise", ""));
    std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 5) {
        fmt::print(stderr, "usage: bench_measurement_errors FAMILY FIRST COUNT FILE [SPHERES]\n");
        return 2;
    }
    const std::uint64_t first = std::strtoull(argv[2], nullptr, 10);
    const std::uint64_t count = std::strtoull(argv[3], nullptr, 10);
    const int spheres = argc > 5 ? std::atoi(argv[5]) : 56;
    bench::ResultFile results(argv[4]);
    results.add(
        bench::numbered(first, count, {{"family", argv[1]}, {"spheres", spheres}}),
        [&](const json& key) { return case_of(key["family"], key["number"], key["spheres"]); },
        print);
    std::map<std::string, int> answers;
    for (const json& each : results.cases())
        if (each["family"] == argv[1])
            ++answers[each["answer"].get<std::string>()];
    for (const auto& [answer, times] : answers)
        fmt::print("{}: {}\n", answer, times);
    return 0;
}
