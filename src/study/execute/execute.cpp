// SPDX-License-Identifier: BSD-3-Clause
#include "study/execute/execute.hpp"

#include "archive/journal/writer.hpp"
#include "archive/trajectory/writer.hpp"
#include "core/error.hpp"
#include "core/utc_time.hpp"
#include "farm/communicator.hpp"
#include "run/simulate.hpp"
#include "study/config/study_config.hpp"
#include "study/execute/journal_notes.hpp"
#include "study/execute/point_results.hpp"
#include "study/execute/study_folder.hpp"

#include <array>
#include <chrono>
#include <optional>
#include <set>
#include <span>

#include <fmt/core.h>
#include <unistd.h>

namespace culm::study {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

int rank_of(const farm::Communicator* communicator) {
    return communicator == nullptr ? 0 : communicator->rank();
}

int ranks_of(const farm::Communicator* communicator) {
    return communicator == nullptr ? 1 : communicator->size();
}

std::string host_name() {
    std::array<char, 256> name{};
    ::gethostname(name.data(), name.size() - 1);
    return name.data();
}

/// Computes batches and commits each point to this rank's journal.
class PointWorker {
  public:
    PointWorker(const Study& study, archive::JournalWriter& journal,
                archive::TrajectoryWriter& trajectories, const ComputePoint& compute_point)
        : study_(study), journal_(journal), trajectories_(trajectories),
          compute_point_(compute_point) {}

    farm::BatchReport operator()(const farm::Batch& batch, farm::Heartbeat& heartbeat) {
        const auto start = Clock::now();
        std::vector<run::CaseSpec> specs;
        for (const std::int64_t point : batch.points)
            specs.push_back(case_of_point(study_.config, study_.design, point));
        const auto go_on = [&heartbeat] {
            heartbeat.beat();
            return !heartbeat.stop_requested();
        };
        farm::BatchReport report;
        std::size_t kept = 0;
        // Each point is in the journal before the next one is counted, so points that the farm
        // reports as done survive the death of this process.
        const auto commit = [&](archive::PointRecord record) {
            const auto computed = Clock::now();
            if (!record.positions.empty())
                record.trajectory = trajectories_.write(record.positions);
            journal_.append(record);
            storage_s_ += seconds_since(computed);
            ++kept;
            ++(record.completed ? report.completed : report.failed);
            heartbeat.beat();
        };
        try {
            journal_.mark_started(batch.points);
            if (compute_point_) {
                for (const run::CaseSpec& spec : specs)
                    commit(compute_point_(spec));
            } else if (study_.config.kind == StudyKind::Timestep) {
                for (const run::CaseSpec& spec : specs)
                    commit(compute_timestep_point(study_.config, spec, go_on, simulator_));
            } else {
                std::vector<run::CaseOutcome> outcomes = simulator_.simulate_together(specs, go_on);
                for (std::size_t k = 0; k < specs.size(); ++k)
                    commit(make_record(specs[k], std::move(outcomes[k]), study_.config.reduce));
            }
        } catch (const run::Abandoned&) {
            // A later run with --resume computes the points that were not recorded.
        } catch (const core::StorageError& error) {
            // Records appended before the failure are in the journal, so they are counted.
            report.storage_failure = error.what();
        } catch (...) {
            give_back(std::span(batch.points).subspan(kept));
            throw;
        }
        give_back(std::span(batch.points).subspan(kept));
        report.seconds = seconds_since(start);
        return report;
    }

    [[nodiscard]] double storage_s() const { return storage_s_; }

  private:
    /// Without the marks the points would count as deaths of this process. That makes a restart
    /// slower but loses no data.
    void give_back(std::span<const std::int64_t> points) {
        if (points.empty())
            return;
        try {
            journal_.mark_given_back(points);
        } catch (const core::StorageError&) {
            return;
        }
    }

    const Study& study_;
    archive::JournalWriter& journal_;
    archive::TrajectoryWriter& trajectories_;
    const ComputePoint& compute_point_;
    run::Simulator simulator_;
    double storage_s_ = 0.0;
};

/// The record of a point that is no longer tried.
archive::PointRecord given_up_record(std::int64_t point, int crash_limit) {
    return failed_record(
        point, archive::rank_died,
        fmt::format("the process that computed this point died {} time{} (--crash-limit {}); "
                    "--retry-failed tries it again",
                    crash_limit, crash_limit == 1 ? "" : "s", crash_limit));
}

/// Times of these batches that earlier runs measured, the same on every rank. Their weight is at
/// most one batch for each rank, because the machine may be another one. Collective.
farm::Pace earlier_pace(const StudyFolder& folder, const std::vector<farm::Batch>& batches,
                        const farm::Communicator* communicator) {
    const farm::Pace pace = farm::on_root(communicator, [&] { return read_pace(folder); });
    const double longest =
        batches.empty() ? 0.0 : std::ranges::max(batches, {}, &farm::Batch::cost).cost;
    // This run's first batch of every rank counts as much as all earlier runs together, which may
    // have been on another machine.
    return pace.with_weight_up_to(longest * ranks_of(communicator));
}

/// Expected time of the cheapest batch, s; that of make_batches if no times are known.
double shortest_expected_time(const std::vector<farm::Batch>& batches, const farm::Pace& pace) {
    if (batches.empty())
        return 0.0;
    const double cost = std::ranges::min(batches, {}, &farm::Batch::cost).cost;
    return cost * (pace.is_known() ? pace.cautious() : 1.0);
}

void compute(const Study& study, const FolderContent& content, const StudyFolder& folder,
             const farm::Communicator* communicator, const ExecuteOptions& options,
             ExecuteOutcome& outcome) {
    const archive::StudyDescription description = description_of(study, options.provenance);
    archive::TrajectoryWriter trajectories(
        folder.trajectories(), static_cast<std::uint32_t>(rank_of(communicator)), description,
        std::ssize(content.pending_points) / ranks_of(communicator));
    std::optional<archive::JournalWriter> journal;
    std::string complaint;
    try {
        journal.emplace(folder.journal_of_rank(rank_of(communicator)), study.config.identity(),
                        archive::JournalOptions{.lock_wait = options.lock_wait});
        if (rank_of(communicator) == 0)
            for (const std::int64_t point : content.given_up_points)
                journal->append(given_up_record(point, options.folder.crash_limit));
    } catch (const core::StorageError& error) {
        complaint = error.what();
    }
    // All ranks must know of a failure: if one rank left alone, the others would wait in the map.
    const bool any_failed = communicator != nullptr
                                ? communicator->is_true_anywhere(!journal.has_value())
                                : !journal.has_value();
    if (any_failed)
        throw core::StorageError(complaint.empty() ? "another rank cannot write its journal"
                                                   : complaint);

    const std::vector<farm::Batch> batches =
        make_batches(study, content.pending_points, content.suspect_points);
    PointWorker worker(study, *journal, trajectories, options.compute_point);
    const auto work = std::ref(worker);
    farm::FarmOptions farm_options = options.farm;
    farm_options.seconds_per_cost = 1.0; // make_batches plans in seconds
    // An earlier job on this study has measured the times that are otherwise estimated; a deadline
    // needs the measured ones.
    farm_options.pace = earlier_pace(folder, batches, communicator);
    if (options.announce && rank_of(communicator) == 0)
        options.announce(estimate(study, batches), farm_options.pace);
    if (communicator == nullptr)
        outcome.farm = farm::Farm().map(batches, work, farm_options);
    else
        outcome.farm = farm::Farm(*communicator).map(batches, work, farm_options);
    outcome.storage_s = worker.storage_s();
    outcome.shortest_batch_s = shortest_expected_time(batches, outcome.farm.pace);
    trajectories.sync();
    journal->close();
    if (rank_of(communicator) == 0)
        write_pace(folder, outcome.farm.pace);
    // Rank 0 reads all journals next: they must be closed.
    if (communicator != nullptr)
        communicator->barrier();
}

/// The note informs people who watch the study. A full disk is reported by the journals.
void leave_note(const Study& study, const StudyFolder& folder, const std::string& start,
                const FolderContent& content, const farm::Communicator* communicator,
                const ExecuteOptions& options) {
    archive::Texts note = provenance_of(study.config, options.provenance);
    note.emplace_back("points", std::to_string(study.design.point_count()));
    note.emplace_back("start", start);
    note.emplace_back("pending", std::to_string(content.pending_points.size()));
    note.emplace_back("journalled", std::to_string(content.journalled));
    note.emplace_back("ranks", std::to_string(ranks_of(communicator)));
    try {
        write_note(folder, note);
    } catch (const core::StorageError&) {
        return;
    }
}

std::string distinct_hosts(const farm::Communicator* communicator) {
    if (communicator == nullptr)
        return host_name();
    const std::vector<std::string> names = communicator->gather(host_name());
    const std::set<std::string> distinct(names.begin(), names.end());
    return fmt::format("{}", fmt::join(distinct, " "));
}

} // namespace

ExecuteOutcome execute(const Study& study, const StudyFolder& folder,
                       const farm::Communicator* communicator, const ExecuteOptions& options) {
    const std::string start = core::utc_now_text();
    std::optional<FolderLock> lock; // on rank 0, until the archive is written
    FolderContent content = farm::on_root(communicator, [&] {
        make_writable(folder);
        lock.emplace(folder, options.lock_wait);
        return prepare_folder(folder, study.config.identity(), study.design.point_count(),
                              options.folder);
    });
    ExecuteOutcome outcome;
    outcome.lost_trajectories = content.lost_trajectories;
    outcome.resumed_points =
        study.design.point_count() - static_cast<std::int64_t>(content.pending_points.size());
    for (auto* points :
         {&content.pending_points, &content.suspect_points, &content.given_up_points})
        std::erase_if(*points, [&](std::int64_t point) {
            return point % options.part.count != options.part.number - 1;
        });
    if (content.archive_is_complete) {
        outcome.archive_is_complete = true;
        return outcome;
    }
    if (rank_of(communicator) == 0)
        leave_note(study, folder, start, content, communicator, options);
    compute(study, content, folder, communicator, options, outcome);

    archive::Texts provenance = provenance_of(study.config, options.provenance);
    provenance.emplace_back("hosts", distinct_hosts(communicator));
    provenance.emplace_back("ranks", std::to_string(outcome.farm.ranks));
    provenance.emplace_back("start", start);
    provenance.emplace_back("end", core::utc_now_text());
    provenance.emplace_back("wall_s", fmt::format("{:.3f}", outcome.farm.elapsed_s));
    if (outcome.farm.pace.is_known())
        provenance.emplace_back("pace", fmt::format("{:.6g}", outcome.farm.pace.mean()));
    const auto assembly_start = Clock::now();
    outcome.archive_is_complete =
        farm::on_root(communicator, [&] { return assemble_archive(study, folder, provenance); });
    outcome.assembly_s = seconds_since(assembly_start);
    return outcome;
}

} // namespace culm::study
