// SPDX-License-Identifier: BSD-3-Clause
// culm-track: the part of culm that reads videos. `culm track` executes it with its command line.
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "core/describe.hpp"
#include "farm/item_map.hpp"
#include "measure/release/swing_release.hpp"
#include "measure/track/frames/frame_source.hpp"
#include "measure/track/track_report.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::cli {
namespace {

/// The outcome of one video.
struct VideoOutcome {
    std::string text;
    bool is_tracked = false;
};

/// Settings of all videos, each with a separate folder; checked before any work begins.
struct TrackPlan {
    std::vector<measure::TrackSettings> settings;
    std::vector<std::filesystem::path> folders;
};

TrackPlan plan_of(const TrackArguments& arguments) {
    TrackPlan plan;
    for (const std::string& video : arguments.videos) {
        plan.settings.push_back(measure::read_track_settings(video));
        const std::string& id = plan.settings.back().description.stem.id;
        std::filesystem::path folder = arguments.output;
        if (arguments.videos.size() > 1)
            folder /= id;
        if (const auto same = std::ranges::find(plan.folders, folder); same != plan.folders.end())
            throw core::InputError(fmt::format(
                "{}: stem.id = \"{}\" is that of {} too; each stem gets a folder of its name",
                video, id, arguments.videos[std::size_t(same - plan.folders.begin())]));
        plan.folders.push_back(folder);
    }
    return plan;
}

int threads_per_rank(int wanted, int ranks) {
    if (wanted > 0)
        return wanted;
    // Ranks on one machine would each take all cores; on several machines this is cautious.
    const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    return std::max(1, cores / ranks);
}

VideoOutcome track_one(const TrackPlan& plan, std::size_t index, int threads) {
    try {
        const measure::Track track = measure::track_video(plan.settings[index], threads);
        measure::write_track(plan.folders[index], track);
        return {fmt::format("{}    written  {}\n", measure::summary_text(track),
                            plan.folders[index].string()),
                true};
    } catch (const core::InputError& error) {
        return {error.what(), false};
    }
}

core::ExitCode print(const TrackPlan& plan, const std::vector<VideoOutcome>& outcomes,
                     const std::vector<std::string>& failures) {
    std::vector<std::string> tracked;
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
        if (outcomes[i].is_tracked) {
            tracked.push_back(plan.folders[i].string());
            fmt::print("{}", outcomes[i].text);
        } else if (!outcomes[i].text.empty()) { // otherwise the failures contain the reason
            print_error(outcomes[i].text);
        }
    }
    for (const std::string& failure : failures)
        print_error(failure);
    if (!tracked.empty())
        fmt::print("{}", next_step("culm fit" + as_words(tracked)));
    if (tracked.size() == outcomes.size())
        return core::ExitCode::Done;
    if (outcomes.size() > 1)
        print_error(
            fmt::format("{} of {} videos gave a measurement", tracked.size(), outcomes.size()));
    return tracked.empty() ? core::ExitCode::BadInput : core::ExitCode::PointsFailed;
}

core::ExitCode track(const TrackArguments& arguments, const farm::Communicator* communicator) {
    const TrackPlan plan = plan_of(arguments);
    const int ranks = rank_count(communicator);
    const auto busy = std::min(ranks, static_cast<int>(plan.settings.size()));
    const int threads = threads_per_rank(arguments.threads, busy);
    const auto work = [&](std::size_t index, const core::Heartbeat& heartbeat) {
        heartbeat();
        return track_one(plan, index, threads);
    };
    const std::vector<double> costs(plan.settings.size(), 1.0);
    ProgressDisplay display(!is_root(communicator) || arguments.is_quiet || costs.size() < 2,
                            "videos");
    const farm::ItemOptions options{
        .progress = [&display](const farm::Progress& progress) { display.show(progress); }};
    std::vector<VideoOutcome> outcomes;
    std::vector<std::string> failures;
    for (core::ItemOutcome<VideoOutcome>& video :
         farm::over_ranks(communicator, options)
             .outcomes(costs, work,
                       [](const VideoOutcome& outcome) { return !outcome.is_tracked; })) {
        outcomes.push_back(std::move(video.value).value_or(VideoOutcome{}));
        if (!video.failure.empty())
            failures.push_back(std::move(video.failure));
    }
    display.finish();
    return farm::on_root(communicator, [&] { return print(plan, outcomes, failures); });
}

/// Prints what was found in a recording as JSON, for postprocess/setup.py.
void print_survey(const std::string& location) {
    const auto source = measure::open_frames("", location);
    const int threads = threads_per_rank(0, 1);
    fmt::print("{}\n", measure::survey_video(*source, threads)
                           .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

/// Numbers from the standard input, as the machine stores them.
std::vector<double> read_doubles(std::size_t count) {
    std::vector<double> values(count);
    std::cin.read(reinterpret_cast<char*>(values.data()),
                  static_cast<std::streamsize>(count * sizeof(double)));
    if (!std::cin)
        throw core::InputError(fmt::format("{} numbers were expected, fewer came", count));
    return values;
}

/// Finds the release in the histories of positions on the standard input, for
/// postprocess/import_recording.py: a line {"samples", "relative_heights", "watched", "release"}
/// and the times and the positions of each height. Prints the release of the watched height, or why
/// there is none, and the centre of every height's swing.
void print_release() {
    std::string line;
    std::getline(std::cin, line);
    const auto request = nlohmann::json::parse(line);
    const auto samples = request.at("samples").get<std::size_t>();
    const auto heights = request.at("relative_heights").get<std::vector<double>>();
    const std::vector<double> times = read_doubles(samples);
    std::vector<std::vector<double>> positions;
    for (std::size_t j = 0; j < heights.size(); ++j)
        positions.push_back(read_doubles(samples));
    nlohmann::json answer;
    double begin = times.empty() ? 0.0 : times.front();
    double period = 0.0;
    if (request.at("release").is_number()) {
        begin = request.at("release");
    } else if (const auto watched = request.at("watched").get<std::size_t>();
               request.at("release") == "detect") {
        try {
            const measure::SwingRelease found =
                measure::find_swing_release(times, positions.at(watched), heights.at(watched));
            begin = found.time;
            period = found.period;
            answer["release"] = {{"time", found.time},     {"uncertainty", found.uncertainty},
                                 {"held", found.held},     {"held_begin", found.held_begin},
                                 {"period", found.period}, {"rest", found.rest}};
        } catch (const core::InputError& error) {
            answer["reason"] = error.what();
        }
    }
    for (const std::vector<double>& history : positions)
        answer["centres"].push_back(measure::centre_of_swing(times, history, begin, period));
    fmt::print("{}\n", answer.dump());
}

} // namespace

core::ExitCode run_track(const TrackArguments& arguments, int& argc, char**& argv) {
    return alone_or_under_launcher(
        argc, argv, [&](const auto* communicator) { return track(arguments, communicator); });
}

} // namespace culm::cli

namespace {

using culm::core::ExitCode;

ExitCode run(int argc, char** argv) {
    CLI::App app("Measures deflections in videos; run it as culm track.", "culm");
    app.require_subcommand(1);
    ExitCode exit_code = ExitCode::Done;
    culm::cli::add_track_command(app, exit_code, argc, argv);
    std::string location;
    CLI::App* survey = app.add_subcommand("survey", "The part of culm setup that reads pictures");
    survey->add_option("location", location)->required();
    survey->callback([&location] { culm::cli::print_survey(location); });
    app.add_subcommand("release", "The part of culm import that finds the release")->callback([] {
        culm::cli::print_release();
    });
    std::string document;
    CLI::App* schema = app.add_subcommand("schema", "The part of culm schema on track.json");
    schema->add_option("name", document)->required();
    schema->callback([] {
        fmt::print("{}\n",
                   culm::core::titled_schema(culm::measure::track_schema(), "culm track").dump(2));
    });
    try {
        return culm::cli::with_refusals(true, [&] {
            app.parse(argc, argv);
            return exit_code;
        });
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? ExitCode::Done : ExitCode::BadInput;
    }
}

} // namespace

int main(int argc, char** argv) {
    try {
        return static_cast<int>(run(argc, argv));
    } catch (const std::exception& error) {
        culm::cli::print_error(fmt::format("internal error: {}", error.what()));
        return 1;
    }
}
