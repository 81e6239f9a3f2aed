// SPDX-License-Identifier: BSD-3-Clause
// A study as its TOML file describes it (docs/config.md), validated and in SI units.
#pragma once

#include "run/case_spec.hpp"
#include "study/config/parameters.hpp"
#include "study/config/study_effects.hpp"
#include "study/design/factor.hpp"
#include "study/design/sampling.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::study {

/// What is computed at each point.
enum class StudyKind {
    Vibration, ///< the free vibration, to which Eq. 1 is fitted
    Timestep,  ///< the limit of the explicit step, and the errors of b1 and b2 at smaller steps
};

/// How design points are made from the factors; design.hpp defines each.
enum class DesignType { Factorial, LatinHypercube, Sobol, List };

struct DesignOptions {
    DesignType type = DesignType::Factorial;
    std::int64_t points = 0; ///< Latin hypercube, Sobol and list; a factorial's follows from levels
    std::int64_t replicates = 1;              ///< stems for each design point
    std::int64_t tests = 1;                   ///< of each stem
    Scrambling scrambling = Scrambling::None; ///< of a Sobol sequence

    /// Do points spread over the factors' distributions?
    [[nodiscard]] bool is_sampled() const {
        return type == DesignType::LatinHypercube || type == DesignType::Sobol;
    }
};

/// Texts of files that a study names, by the names as they are written there.
using StudyFiles = std::map<std::string, std::string, std::less<>>;

/// How Eq. 1 is fitted to the histories and the regressions are reduced.
struct ReduceOptions {
    std::optional<double> window;  ///< s from the release; nothing: the whole record
    bool is_amplitude_free = true; ///< is b0 fitted, or fixed at the initial deflection?
    double significance = 0.05;    ///< of the nested F-tests
};

/// Options of a study of kind Timestep.
struct TimestepOptions {
    double limit_tolerance = 0.01;     ///< of the bisected limit
    std::int64_t trial_steps = 20'000; ///< of every run of the bisection
    /// Steps, as shares of the linearised limit, whose b1 and b2 are compared; ascending. Empty:
    /// the limits alone.
    std::vector<double> fractions;
    double record_cycles = 2.0;          ///< of each such run, in periods of the undamped stem
    std::int64_t samples_per_cycle = 40; ///< of its history
    double reference_tolerance = 1e-9;   ///< of the implicit reference run
};

struct StudyConfig {
    StudyKind kind = StudyKind::Vibration;
    std::string name;
    std::uint64_t seed = 1;
    ParameterValues given;       ///< by [stem] and [release]
    run::CaseSpec base;          ///< everything but the factors; its stem and release hold `given`
    StudyEffects effects;        ///< beyond the published chain
    std::vector<Factor> factors; ///< in the order of the file
    DesignOptions design;
    ReduceOptions reduce;
    TimestepOptions timestep;
    int trajectory_compression = 0; ///< 0 (none) to 9
    bool single_precision_trajectories = false;
    std::string file; ///< name for messages
    std::string text; ///< the file as it was read
    StudyFiles files; ///< tables of measured stems that it names

    /// Sorted "key = value" lines of everything that influences the results, after defaults and in
    /// config units: two studies with equal identities compute the same archive. The name, the
    /// compression, comments and formatting are not part of it.
    [[nodiscard]] std::string identity() const;
};

/// Reads and validates a study. Throws core::InputError with ALL errors of the file, one a line, as
/// `file:line: section.key = value: what is allowed`.
[[nodiscard]] StudyConfig load_config(const std::filesystem::path& file);

/// The same for text that was read elsewhere; `file` is used in messages, and its stem as the name
/// of a study that has none. A file in `files` is not looked for on the disk.
[[nodiscard]] StudyConfig parse_config(std::string_view text, const std::string& file,
                                       const StudyFiles& files = {});

/// Differences between two identities, one line for each key; empty if they are equal. The first
/// is called "stored", the second "now".
[[nodiscard]] std::string difference(const std::string& stored, const std::string& now);

/// All files as one text for an archive (a JSON object: name, text), and back. The latter throws
/// core::InputError if the text has another form; an empty text means no files.
[[nodiscard]] std::string to_text(const StudyFiles& files);
[[nodiscard]] StudyFiles files_from_text(const std::string& text);

/// How the study integrates in time, for people.
[[nodiscard]] std::string integrator_text(const StudyConfig& config);

} // namespace culm::study
