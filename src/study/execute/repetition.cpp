// SPDX-License-Identifier: BSD-3-Clause
#include "study/execute/repetition.hpp"

#include "archive/study/file.hpp"
#include "core/error.hpp"
#include "study/summary/summary.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include <fmt/format.h>

namespace culm::study {

namespace {

using archive::PointStatus;
using archive::StudyFile;

bool is_same(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
           (std::isnan(a) && std::isnan(b));
}

/// Notes the differences of one point's numbers; relative ones refer to `size`.
void compare_numbers(std::int64_t point, std::span<const double> archived,
                     std::span<const double> now, double size, DifferingNumbers& numbers) {
    bool is_differing = archived.size() != now.size();
    for (std::size_t k = 0; k < std::min(archived.size(), now.size()); ++k) {
        if (is_same(archived[k], now[k]))
            continue;
        is_differing = true;
        const double gap = std::abs(now[k] - archived[k]);
        numbers.largest = std::max(numbers.largest, gap);
        if (size > 0.0)
            numbers.largest_relative = std::max(numbers.largest_relative, gap / size);
    }
    if (is_differing && numbers.points++ == 0)
        numbers.first_point = point;
}

void note(const DifferingNumbers& numbers, Repetition& repetition) {
    ++repetition.datasets;
    if (numbers.points > 0)
        repetition.differing.push_back(numbers);
}

using Points = std::vector<std::int64_t>;

/// Compares outcomes; returns the points that completed in both archives.
Points compare_outcomes(const StudyFile& archived, const StudyFile& now, Repetition& repetition) {
    Points completed;
    for (std::int64_t point = 0; point < archived.point_count(); ++point) {
        const PointStatus before = archived.status(point);
        if (before == PointStatus::Missing) {
            ++repetition.missing;
            continue;
        }
        ++repetition.points;
        // The reason of a failure is a sentence and may be reworded; its kind must not change.
        const bool is_other = before != now.status(point) ||
                              (before == PointStatus::Failed &&
                               archived.failure_kind(point) != now.failure_kind(point));
        if (is_other)
            repetition.other_outcomes.push_back(point);
        else if (before == PointStatus::Completed)
            completed.push_back(point);
    }
    return completed;
}

void compare_columns(const std::vector<double>& archived, const std::vector<double>& now,
                     const Points& points, DifferingNumbers numbers, Repetition& repetition) {
    for (const std::int64_t point : points) {
        const auto k = static_cast<std::size_t>(point);
        compare_numbers(point, std::span(archived).subspan(k, 1), std::span(now).subspan(k, 1),
                        std::abs(archived[k]), numbers);
    }
    note(numbers, repetition);
}

/// The history of a point.
using History = std::vector<double> (StudyFile::*)(std::int64_t) const;

void compare_histories(const StudyFile& archived, const StudyFile& now, const Points& points,
                       const std::string& name, History history, Repetition& repetition) {
    DifferingNumbers numbers{.name = name, .unit = "m"};
    for (const std::int64_t point : points) {
        const std::vector<double> before = (archived.*history)(point);
        double size = 0.0;
        for (const double value : before)
            size = std::isfinite(value) ? std::max(size, std::abs(value)) : size;
        compare_numbers(point, before, (now.*history)(point), size, numbers);
    }
    note(numbers, repetition);
}

void compare_tables(const StudyFile& archived, const StudyFile& now, const Points& completed,
                    Repetition& repetition) {
    Points all(static_cast<std::size_t>(archived.point_count()));
    std::iota(all.begin(), all.end(), std::int64_t{0});
    for (const archive::Column& column : archived.description().factors)
        compare_columns(archived.factor(column.name), now.factor(column.name), all,
                        {.name = "design/" + column.name, .unit = column.unit}, repetition);
    for (const archive::Column& column : archived.description().results)
        compare_columns(archived.result(column.name), now.result(column.name), completed,
                        {.name = "results/" + column.name, .unit = column.unit}, repetition);
}

void compare_stored_histories(const StudyFile& archived, const StudyFile& now,
                              const Points& completed, Repetition& repetition) {
    const archive::StoredHistories& stored = archived.description().stored;
    const auto compare = [&](bool is_stored, const std::string& name, History history) {
        if (is_stored)
            compare_histories(archived, now, completed, name, history, repetition);
    };
    compare(stored.tip, "histories/tip_deflection", &StudyFile::tip_deflection);
    compare(stored.heights, "histories/height_deflection", &StudyFile::height_deflection);
    compare(stored.positions, "particles", &StudyFile::positions);
}

void require_whole(const StudyFolder& folder) {
    const archive::Verification found = archive::verify(folder.archive());
    if (!found.is_whole())
        throw core::InputError(fmt::format(
            "{}: {} of {} datasets are damaged, the first is {}; `culm archive verify {}` lists "
            "them",
            folder.archive().string(), found.damaged.size(), found.datasets,
            found.damaged.front().name, folder.path().string()));
}

} // namespace

void require_comparable(const StudyFolder& folder) {
    try {
        require_whole(folder);
        const StudyFile file(folder.archive());
        static_cast<void>(file.design());
        for (const archive::Column& column : file.description().results)
            static_cast<void>(file.result(column.name));
        for (std::int64_t point = 0; point < file.point_count(); ++point)
            static_cast<void>(file.record(point));
    } catch (const core::StorageError& error) {
        throw core::InputError(error.what());
    }
}

Study study_to_repeat(const StudyFolder& folder) {
    try {
        ArchivedStudy archived = open_archive(folder);
        const std::string differing =
            difference(archived.file.description().identity, archived.study.config.identity());
        if (!differing.empty())
            throw core::InputError(fmt::format(
                "{}: this culm ({} wrote the archive) interprets the study differently:\n{}",
                folder.archive().string(), provenance_text(archived.file, "version"), differing));
        return std::move(archived.study);
    } catch (const core::StorageError& error) {
        throw core::InputError(error.what());
    }
}

Repetition compare_archives(const StudyFile& archived, const StudyFile& now) {
    const auto& columns = archived.description();
    const auto& columns_now = now.description();
    if (archived.point_count() != now.point_count() || columns.factors != columns_now.factors ||
        columns.results != columns_now.results || columns.stored != columns_now.stored)
        throw core::InputError(fmt::format("{} and {} have different tables",
                                           archived.path().string(), now.path().string()));
    Repetition repetition;
    const Points completed = compare_outcomes(archived, now, repetition);
    compare_tables(archived, now, completed, repetition);
    compare_stored_histories(archived, now, completed, repetition);
    for (const char* name :
         {"version", "compiler", "build", "libraries", "hosts", "ranks", "start"})
        repetition.facts.push_back(
            {name, provenance_text(archived, name), provenance_text(now, name)});
    return repetition;
}

} // namespace culm::study
