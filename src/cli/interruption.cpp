// SPDX-License-Identifier: BSD-3-Clause
#include "cli/interruption.hpp"

#include "cli/command_line.hpp"
#include "cluster/batch_system.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <vector>

#include <fmt/core.h>

namespace culm::cli {
namespace {

// A signal handler can access only variables of static storage.
volatile std::sig_atomic_t stop_signal = 0;

void remember_stop(int signal) {
    stop_signal = signal;
}

std::optional<cluster::TimeLeft> time_left(const std::string& walltime,
                                           farm::Clock::time_point start) {
    if (walltime.empty())
        return cluster::time_left_of_job(cluster::real_batch_system());
    const std::chrono::duration<double> used = farm::Clock::now() - start;
    return cluster::TimeLeft{cluster::parse_walltime("--walltime", walltime) - used.count(),
                             "--walltime"};
}

namespace fs = std::filesystem;

fs::path file_in(const fs::path& folder, bool resumes) {
    fs::path file = folder / "unfinished.culmj";
    if (!resumes && fs::exists(file))
        throw core::InputError(fmt::format("{} contains an unfinished diagnosis: continue it with "
                                           "--resume, or choose another folder",
                                           folder.string()));
    return file;
}

archive::PointRecord record_of(std::int64_t number, const core::Bytes& value) {
    archive::PointRecord record;
    record.point = number;
    record.completed = true;
    record.values.resize(1 + (value.size() + sizeof(double) - 1) / sizeof(double));
    record.values.front() = static_cast<double>(value.size());
    std::memcpy(record.values.data() + 1, value.data(), value.size());
    return record;
}

core::Bytes value_of(const archive::PointRecord& record) {
    core::Bytes value(static_cast<std::size_t>(record.values.front()));
    std::memcpy(value.data(), record.values.data() + 1, value.size());
    return value;
}

} // namespace

void watch_stop_signals() {
    for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGUSR2})
        std::signal(signal, remember_stop);
    std::signal(SIGXFSZ, SIG_IGN);
}

bool has_stop_signal() {
    return stop_signal != 0;
}

std::function<bool()> stop_after_signal(const farm::Communicator* communicator,
                                        const std::string& what, const std::string& folder) {
    const bool announces = is_root(communicator) && communicator != nullptr;
    return [announces, what, folder, is_announced = false]() mutable {
        if (announces && stop_signal == SIGTERM && !is_announced) {
            is_announced = true;
            print_note(
                fmt::format("stopping; {} are kept in {}. Continue with --resume.", what, folder));
        }
        return has_stop_signal();
    };
}

std::optional<RunDeadline> run_deadline(const std::string& walltime, farm::Clock::time_point start,
                                        const farm::Communicator* communicator) {
    // All ranks must agree.
    const auto answer = farm::on_root(communicator, [&] { return time_left(walltime, start); });
    if (!answer)
        return std::nullopt;
    const auto& [left, source] = *answer;
    const double usable = std::max(0.0, left - std::clamp(left / 50.0, 1.0, 60.0));
    return RunDeadline{farm::Clock::now() + std::chrono::duration_cast<farm::Clock::duration>(
                                                std::chrono::duration<double>(usable)),
                       fmt::format("this run ends within {} ({}); {} of that may be computed",
                                   cluster::walltime_text(std::max(0.0, left)), source,
                                   cluster::walltime_text(usable))};
}

KeptItems::KeptItems(const fs::path& folder, const std::string& identity, bool resumes)
    : writer_(file_in(folder, resumes), identity),
      index_(std::vector{archive::scan_journal(writer_.path(), identity)}) {}

farm::ItemStore KeptItems::store() {
    return {[this](std::int64_t number) {
                const auto record = index_.find_record(number);
                return record ? std::optional(value_of(*record)) : std::nullopt;
            },
            [this](std::int64_t number, const core::Bytes& value) {
                writer_.append(record_of(number, value));
            }};
}

void KeptItems::remove() {
    writer_.close();
    fs::remove(writer_.path());
}

} // namespace culm::cli
