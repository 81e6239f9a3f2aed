// SPDX-License-Identifier: BSD-3-Clause
// culm archive info|status|verify|merge DIR
#include "cli/options.hpp"
#include "cli/provenance.hpp"
#include "present/files.hpp"
#include "present/study/study.hpp"
#include "study/execute/execute.hpp"
#include "study/execute/folder_state.hpp"

#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <unistd.h>

namespace culm::cli {
namespace {

struct LookArguments {
    std::string folder;
    std::string json;
    bool follows = false;
};

using Text = std::function<std::string(const study::StudyFolder&, const study::FolderState&)>;
using Check = std::function<bool(const study::FolderState&)>;

/// Prints the state again every two seconds, in place on a terminal, as long as the study runs.
study::FolderState follow(const study::StudyFolder& folder, study::FolderState state,
                          const Text& text) {
    const bool is_terminal = ::isatty(STDOUT_FILENO) == 1;
    for (; state.is_running();
         state = study::read_folder_state(folder, study::FolderDepth::Glance)) {
        fmt::print("{}{}{}", is_terminal ? "\x1b[H\x1b[J" : "", text(folder, state),
                   is_terminal ? "" : "\n");
        std::fflush(stdout);
        std::this_thread::sleep_for(std::chrono::seconds(2));
    }
    return state;
}

/// Adds a command that prints the state of a folder; its exit code is 3 if the state `is_bad`.
void add_look(CLI::App& archive, core::ExitCode& exit_code, const char* name,
              const char* description, study::FolderDepth depth, const Text& text,
              const Check& is_bad) {
    CLI::App* command = archive.add_subcommand(name, description);
    auto arguments = std::make_shared<LookArguments>();
    add_option(*command, "dir", arguments->folder, "DIR", "Folder of a study, complete or not")
        ->required();
    add_option(*command, "--json", arguments->json, "FILE",
               "Write it as JSON to this file (- for stdout)");
    if (std::string_view(name) == "status")
        command->add_flag("--follow", arguments->follows,
                          "Print it again every two seconds until the study ends");
    command->callback([arguments, &exit_code, depth, text, is_bad] {
        const study::StudyFolder folder(arguments->folder);
        study::FolderState state = study::read_folder_state(folder, depth);
        if (arguments->follows)
            state = follow(folder, std::move(state), text);
        if (!arguments->json.empty())
            present::write_json(arguments->json, present::folder_json(state));
        if (arguments->json != "-")
            fmt::print("{}", text(folder, state));
        if (is_bad(state))
            exit_code = core::ExitCode::PointsFailed;
    });
}

struct MergeArguments {
    std::vector<std::string> folders;
    std::string output;
};

void merge(const MergeArguments& arguments, core::ExitCode& exit_code) {
    std::vector<study::StudyFolder> sources;
    for (const std::string& folder : arguments.folders)
        sources.emplace_back(folder);
    const study::StudyFolder target(arguments.output);
    const study::MergeOutcome outcome = study::merge_folders(sources, target, build_provenance());
    fmt::print("{} points: {} completed, {} failed, {} missing\narchive {}\n", outcome.points,
               outcome.completed, outcome.failed, outcome.missing, target.archive().string());
    if (outcome.repeated > 0)
        fmt::print("{} of them are in more than one folder\n", outcome.repeated);
    if (!outcome.differing.empty())
        print_warning(fmt::format("the folders differ in points {}; the folder named first is used",
                                  present::ranges_text(outcome.differing)));
    if (outcome.missing > 0 || outcome.failed > 0 || !outcome.differing.empty())
        exit_code = core::ExitCode::PointsFailed;
}

void add_merge(CLI::App& archive, core::ExitCode& exit_code) {
    CLI::App* command = archive.add_subcommand(
        "merge", "One study.h5 from the journals and archives of folders of the same study");
    auto arguments = std::make_shared<MergeArguments>();
    add_option(*command, "dirs", arguments->folders, "DIR...",
               "Folders of the same study; they are not changed")
        ->required();
    add_option(*command, "-o,--output", arguments->output, "DIR",
               "Folder for the study.h5 to be written")
        ->required();
    command->callback([arguments, &exit_code] { merge(*arguments, exit_code); });
}

} // namespace

void add_archive_command(CLI::App& app, core::ExitCode& exit_code) {
    CLI::App* archive =
        app.add_subcommand("archive", "Look at, check and merge the folder of a study");
    archive->require_subcommand(1);
    // `info` and `status` summarise the folder without reading the data.
    const Check has_problems = [](const auto& state) { return !state.problems.empty(); };
    add_look(*archive, exit_code, "info",
             "What is in a study's folder: points, tables, histories, provenance, size",
             study::FolderDepth::Glance, present::info_text, has_problems);
    add_look(
        *archive, exit_code, "status",
        "Progress of a study, also while it runs; reads headers only", study::FolderDepth::Glance,
        [](const auto&, const auto& state) { return present::status_text(state); }, has_problems);
    add_look(
        *archive, exit_code, "verify",
        "Check every checksum and list what is damaged or missing (exit code 3)",
        study::FolderDepth::Verify,
        [](const auto&, const auto& state) { return present::verify_text(state); },
        [](const auto& state) { return !state.is_whole(); });
    add_merge(*archive, exit_code);
}

} // namespace culm::cli
