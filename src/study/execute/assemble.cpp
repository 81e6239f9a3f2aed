// SPDX-License-Identifier: BSD-3-Clause
#include "archive/journal/read.hpp"
#include "archive/study/file.hpp"
#include "archive/study/writer.hpp"
#include "archive/trajectory/reader.hpp"
#include "core/error.hpp"
#include "core/user_files.hpp"
#include "study/config/study_config.hpp"
#include "study/execute/execute.hpp"
#include "study/execute/extension.hpp"
#include "study/execute/folder_state.hpp"
#include "study/execute/journal_notes.hpp"
#include "study/execute/point_results.hpp"
#include "study/summary/summary.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/core.h>

namespace culm::study {

archive::StudyDescription description_of(const Study& study, const archive::Texts& provenance) {
    const run::CaseSpec& base = study.config.base;
    archive::StudyDescription description;
    description.points = study.design.point_count();
    for (const Factor& factor : study.design.factors) {
        const std::string_view unit = factor.parameter->unit.name;
        description.factors.push_back({std::string(factor.parameter->key),
                                       unit.empty() ? "1" : std::string(unit),
                                       std::string(factor.parameter->meaning)});
    }
    description.results = result_columns(study.config);
    description.stored.tip = base.store >= run::StoreLevel::Tip;
    description.stored.heights = base.store >= run::StoreLevel::Heights && !base.heights.empty();
    description.stored.positions = base.store == run::StoreLevel::Full;
    if (description.stored.tip)
        description.times = sample_times(base);
    if (description.stored.heights)
        description.heights = base.heights;
    description.spheres = base.stem.sphere_count;
    description.identity = study.config.identity();
    description.version = archive::text_named("version", provenance);
    description.provenance = provenance;
    description.trajectory_compression = study.config.trajectory_compression;
    description.single_precision = study.config.single_precision_trajectories;
    return description;
}

archive::Texts provenance_of(const StudyConfig& config, archive::Texts facts) {
    facts.emplace_back("config", config.text);
    facts.emplace_back("config_file", config.file);
    if (!config.files.empty())
        facts.emplace_back("config_files", to_text(config.files));
    facts.emplace_back("study_name", config.name);
    facts.emplace_back("seed", std::to_string(config.seed));
    return facts;
}

namespace {

using archive::PointRecord;
using archive::PointStatus;

/// (points, factors), row-major, in the units of the factors' keys.
std::vector<double> design_in_config_units(const Design& design) {
    std::vector<double> values = design.values;
    for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = design.factors[k % design.factors.size()].parameter->unit.from_si(values[k]);
    return values;
}

/// Writes the study file, with the integrator's work on all completed points in its provenance.
void write_archive(const std::filesystem::path& path, const Study& study,
                   const archive::Texts& provenance, const archive::RecordSource& record_of_point) {
    const std::vector<std::string> names = work_columns(study.config);
    std::vector<double> sums(names.size(), 0.0);
    const auto counted_record = [&](std::int64_t point) {
        std::optional<PointRecord> record = record_of_point(point);
        if (record && record->completed)
            for (std::size_t k = 0; k < sums.size(); ++k)
                sums[k] += record->values[record->values.size() - sums.size() + k];
        return record;
    };
    const auto totals = [&] {
        std::vector<std::pair<std::string, std::int64_t>> entries;
        for (std::size_t k = 0; k < sums.size(); ++k)
            entries.emplace_back("total_" + names[k], std::llround(sums[k]));
        return entries;
    };
    archive::write_study_file(path, description_of(study, provenance),
                              design_in_config_units(study.design), counted_record, totals);
}

/// The records of one folder, from its journals and from the archive next to them.
class FolderRecords {
  public:
    FolderRecords(const StudyFolder& folder, const std::string& identity)
        : index_(archive::scan_journal_folder(folder.journals(), identity)),
          trajectories_(folder.trajectories()) {
        if (is_there(folder.archive()))
            archive_.emplace(folder.archive());
    }

    [[nodiscard]] bool contains(std::int64_t point) const {
        return index_.contains(point) ||
               (archive_ && archive_->status(point) != PointStatus::Missing);
    }
    /// A completed outcome takes precedence over a failed one, wherever it is stored; of two failed
    /// ones that of the journals, which are younger than the archive.
    [[nodiscard]] std::optional<PointRecord> find_record(std::int64_t point) {
        std::optional<PointRecord> latest = index_.find_record(point);
        const bool archive_is_better =
            archive_ &&
            (!latest || (!latest->completed && archive_->status(point) == PointStatus::Completed));
        return archive_is_better ? archive_->record(point) : latest;
    }
    /// Reads positions that are stored outside of the record.
    void load_positions(PointRecord& record) {
        if (const auto place = std::exchange(record.trajectory, std::nullopt))
            record.positions = trajectories_.read(*place);
    }

  private:
    archive::JournalIndex index_;
    archive::TrajectoryFolder trajectories_;
    std::optional<archive::StudyFile> archive_;
};

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
    // Compares bits: NaN means "no value" and must equal itself.
    return std::ranges::equal(a, b, [](double x, double y) {
        return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
    });
}

bool is_same_outcome(const PointRecord& a, const PointRecord& b) {
    return a.completed == b.completed && a.failure_kind == b.failure_kind &&
           same_bits(a.values, b.values) && same_bits(a.tip_deflection, b.tip_deflection) &&
           same_bits(a.height_deflection, b.height_deflection) &&
           same_bits(a.positions, b.positions);
}

/// Chooses among the folders' outcomes of a point and counts them.
std::optional<PointRecord> chosen_record(std::vector<FolderRecords>& sources, std::int64_t point,
                                         MergeOutcome& outcome) {
    std::optional<PointRecord> chosen;
    bool is_repeated = false;
    bool is_differing = false;
    for (FolderRecords& source : sources) {
        std::optional<PointRecord> other = source.find_record(point);
        if (!other)
            continue;
        source.load_positions(*other);
        if (chosen) {
            is_repeated = true;
            is_differing = is_differing || !is_same_outcome(*chosen, *other);
        }
        if (!chosen || (other->completed && !chosen->completed))
            chosen = std::move(other);
    }
    ++outcome.points;
    ++(!chosen ? outcome.missing : chosen->completed ? outcome.completed : outcome.failed);
    outcome.repeated += is_repeated ? 1 : 0;
    if (is_differing)
        outcome.differing.push_back(point);
    return chosen;
}

/// The state of a source that is readable to its last byte and is not being written.
FolderState sound_state(const StudyFolder& folder) {
    FolderState state = read_folder_state(folder, FolderDepth::Verify);
    if (state.is_running())
        throw core::InputError(fmt::format("{}: the study is running; merge it when it has ended",
                                           folder.path().string()));
    if (!state.problems.empty())
        throw core::StorageError(state.problems.front());
    if (state.verification && !state.verification->is_whole())
        throw core::StorageError(fmt::format(
            "{}: {} is damaged; `culm archive verify {}` lists more", folder.archive().string(),
            state.verification->damaged.front().name, folder.path().string()));
    return state;
}

constexpr std::string_view extended_entry = "extended_from";

void remove_journals(const StudyFolder& folder) {
    std::error_code error;
    std::filesystem::remove_all(folder.journals(), error);
    if (error)
        throw core::StorageError(
            fmt::format("cannot remove {}, whose points are in the archive: {}",
                        folder.journals().string(), error.message()));
}

/// An interrupted extension leaves the journals of the study whose points the archive has taken in.
void remove_absorbed_journals(const StudyFolder& folder, const archive::Texts& description) {
    const std::string absorbed = archive::text_named(extended_entry, description);
    if (absorbed.empty())
        return;
    for (const std::filesystem::path& journal : archive::journal_files(folder.journals()))
        if (archive::read_journal_identity(journal) == absorbed)
            return remove_journals(folder);
}

/// The description of the other study that a folder holds; nothing if it holds none that can be
/// read.
std::optional<archive::Texts> other_study(const StudyFolder& folder, const std::string& identity) {
    try {
        if (is_there(folder.archive())) {
            const archive::StudyFile file(folder.archive());
            const archive::Texts& texts = file.description().provenance;
            remove_absorbed_journals(folder, texts);
            return file.description().identity == identity ? std::nullopt : std::optional(texts);
        }
        for (const std::filesystem::path& journal : archive::journal_files(folder.journals()))
            if (archive::read_journal_identity(journal) == identity)
                return std::nullopt;
        return read_note(folder);
    } catch (const core::StorageError&) { // prepare_folder says what to do
        return std::nullopt;
    }
}

/// The study as described by the first folder that contains its configuration, and where it ran.
struct Origin {
    Study study;
    std::string ranks;
    std::string start;
};
Origin origin_of(const std::vector<FolderState>& states, const StudyFolder& first) {
    for (const FolderState& state : states)
        if (state.archive || state.note) {
            const archive::Texts& texts = state.archive ? state.archive->provenance : *state.note;
            return {archived_study(texts), archive::text_named("ranks", texts),
                    archive::text_named("start", texts)};
        }
    throw core::InputError(fmt::format(
        "{}: neither study.h5 nor journal/study.json contains the design of the study; `culm run "
        "STUDY.toml -o {} --resume` finishes it",
        first.path().string(), first.path().string()));
}

} // namespace

bool assemble_archive(const Study& study, const StudyFolder& folder,
                      const archive::Texts& provenance) {
    FolderRecords records(folder, study.config.identity());
    for (std::int64_t point = 0; point < study.design.point_count(); ++point)
        if (!records.contains(point))
            return false;
    write_archive(folder.archive(), study, provenance,
                  [&](std::int64_t point) { return records.find_record(point); });
    remove_journals(folder); // the archive is on the disk under its name
    return true;
}

std::optional<Extension> extend_folder(const Study& study, const StudyFolder& folder,
                                       const archive::Texts& facts,
                                       const archive::LockWait& lock_wait) {
    if (!is_there(folder.path()))
        return std::nullopt;
    const FolderLock lock(folder, lock_wait);
    const auto description = other_study(folder, study.config.identity());
    if (!description)
        return std::nullopt;
    const Study stored = archived_study(*description);
    const std::string identity = stored.config.identity();
    if (!may_extend(identity, study.config.identity()))
        return std::nullopt;
    const ExtensionMap map = extension_of(stored, study);
    static_cast<void>(
        prepare_folder(folder, identity, stored.design.point_count(), {.resume = true}));
    Extension extension{0, study.design.point_count(), {}};
    if (map.adds_heights) {
        if (!assemble_archive(stored, folder, *description))
            throw core::InputError(fmt::format(
                "{}: the stored study is not complete; complete it before more heights are stored",
                folder.path().string()));
        const std::filesystem::path former = folder.path() / "study-before-extension.h5";
        std::filesystem::rename(folder.archive(), former);
        extension.former = former.string();
        return extension;
    }
    FolderRecords records(folder, identity);
    archive::Texts provenance = provenance_of(study.config, facts);
    provenance.emplace_back(extended_entry, identity);
    write_archive(folder.archive(), study, provenance, [&](std::int64_t point) {
        const std::int64_t former = map.stored_point[static_cast<std::size_t>(point)];
        auto record = former < 0 ? std::nullopt : records.find_record(former);
        if (record) {
            record->point = point;
            ++extension.kept;
        }
        return record;
    });
    remove_journals(folder);
    return extension;
}

MergeOutcome merge_folders(const std::vector<StudyFolder>& sources, const StudyFolder& target,
                           const archive::Texts& provenance) {
    if (is_there(target.archive()))
        throw core::InputError(fmt::format("{} is there already; choose another folder with -o",
                                           target.archive().string()));
    std::vector<FolderState> states;
    std::vector<FolderRecords> opened;
    std::string names;
    for (const StudyFolder& source : sources) {
        states.push_back(sound_state(source));
        if (states.front().identity != states.back().identity)
            throw core::InputError(
                fmt::format("{} and {} hold different studies. What differs:\n{}",
                            sources.front().path().string(), source.path().string(),
                            difference(states.front().identity, states.back().identity)));
        opened.emplace_back(source, states.back().identity);
        names += (names.empty() ? "" : "\n") + source.path().string();
    }
    const Origin origin = origin_of(states, sources.front());
    archive::Texts texts = provenance_of(origin.study.config, provenance);
    texts.emplace_back("ranks", origin.ranks);
    texts.emplace_back("start", origin.start);
    texts.emplace_back("merged_from", names);
    core::create_folder(target.path());
    MergeOutcome outcome;
    write_archive(target.archive(), origin.study, texts,
                  [&](std::int64_t point) { return chosen_record(opened, point, outcome); });
    return outcome;
}

} // namespace culm::study
