// SPDX-License-Identifier: BSD-3-Clause
// The work of `culm setup`, in culm-track.
#include "cli/build_facts.hpp"
#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "core/user_files.hpp"
#include "measure/setup/setup_dialogue.hpp"
#include "measure/setup/setup_folder.hpp"
#include "measure/setup/setup_page.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>
#include <thread>

#include <fmt/core.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;

/// Written beside its name first: an interrupted command leaves no half of it.
void write_whole(const fs::path& file, const std::string& text) {
    fs::path part = file;
    part += ".part";
    std::ofstream out(part, std::ios::binary);
    out << text;
    out.close();
    std::error_code error;
    if (out)
        fs::rename(part, file, error);
    if (!out || error)
        throw core::StorageError(fmt::format("{}: cannot be written", file.string()));
}

std::optional<std::string> answer_of_terminal(const std::string& question) {
    fmt::print("{}", question);
    std::fflush(stdout);
    std::string line;
    if (!std::getline(std::cin, line))
        return std::nullopt;
    const std::size_t begin = line.find_first_not_of(" \t\r");
    return begin == std::string::npos
               ? std::string()
               : line.substr(begin, line.find_last_not_of(" \t\r") - begin + 1);
}

void set_up(const SetupArguments& arguments) {
    const std::string location = measure::recording_location(arguments.video);
    const auto source = measure::open_frames("", location);
    const fs::path folder = arguments.output;
    measure::SetupRecording recording{folder, "", fmt::format("culm {}", version_number),
                                      "culm track" + as_words({(folder / "video.toml").string()}) +
                                          " -o" + as_words({(folder / "measurement").string()})};
    recording.frames = measure::make_setup_folder(folder, location);
    const int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    const measure::VideoSurvey survey = measure::survey_video(*source, threads);
    fmt::print("{}", measure::survey_text(*source, survey));
    if (arguments.is_text) {
        const std::string text =
            measure::ask_for_settings(answer_of_terminal, recording, *source, survey);
        write_whole(folder / "video.toml", text);
        fmt::print("written  {}\n{}", (folder / "video.toml").string(),
                   next_step(recording.next_command));
        return;
    }
    const fs::path page = folder / "setup.html";
    write_whole(page, measure::setup_page(recording, *source, survey));
    fmt::print("written  {}\n\nnext: open {} in a browser, save video.toml in {}, then\n      {}\n",
               page.string(), page.string(), folder.string(), recording.next_command);
}

} // namespace

core::ExitCode run_setup(const SetupArguments& arguments, char**&) {
    set_up(arguments);
    return core::ExitCode::Done;
}

} // namespace culm::cli
