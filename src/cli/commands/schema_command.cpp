// SPDX-License-Identifier: BSD-3-Clause
// culm schema NAME
#include "cli/options.hpp"
#include "core/describe.hpp"
#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "present/calibration.hpp"
#include "present/comparison.hpp"
#include "present/diagnosis.hpp"
#include "present/laboratory.hpp"
#include "present/ring_down_fits.hpp"
#include "present/study/study.hpp"

#include <array>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::cli {
namespace {

/// A kind of JSON that commands write. The schema of track.json is that of another program.
struct Document {
    const char* name;
    const char* written_by;
    nlohmann::json (*schema)();
};

constexpr std::array documents{
    Document{"summary", "culm run and culm reduce", present::summary_schema},
    Document{"archive", "culm archive info, status and verify --json", present::folder_schema},
    Document{"fit", "culm fit", present::fit_schema},
    Document{"track", "culm track", nullptr},
    Document{"calibration", "culm calibrate", present::calibration_schema},
    Document{"comparison", "culm compare", present::comparison_schema},
    Document{"diagnosis", "culm diagnose, of one stem", present::diagnosis_schema},
    Document{"laboratory", "culm diagnose, of several stems", present::laboratory_schema},
    Document{"effects", "culm effects --json", effects_schema}};

core::ExitCode print_schema(const std::string& name, int& argc, char**& argv) {
    std::vector<std::string> names;
    for (const Document& document : documents) {
        names.emplace_back(document.name);
        if (name != document.name)
            continue;
        if (document.schema == nullptr)
            return run_track({}, argc, argv);
        fmt::print("{}\n", core::titled_schema(document.schema(), document.written_by).dump(2));
        return core::ExitCode::Done;
    }
    throw core::InputError(
        fmt::format("there is no document \"{}\"{}", name, core::did_you_mean(name, names)));
}

void print_list() {
    for (const Document& document : documents)
        fmt::print("{:<12} written by {}\n", document.name, document.written_by);
}

} // namespace

void add_schema_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv) {
    CLI::App* command =
        app.add_subcommand("schema", "The JSON schema of a document that culm writes");
    auto name = std::make_shared<std::string>();
    add_option(*command, "name", *name, "NAME", "Document (default: list all)");
    command->callback([name, &exit_code, &argc, &argv] {
        if (name->empty())
            print_list();
        else
            exit_code = print_schema(*name, argc, argv);
    });
}

} // namespace culm::cli
