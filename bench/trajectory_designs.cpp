// SPDX-License-Identifier: BSD-3-Clause
// Two designs for the trajectories of a rank, killed while they write: what is lost, what is slow?
//
// reserved  the design of culm (archive/trajectory/writer.hpp): files with allocated datasets,
// which
//           HDF5 has closed; a journal holds the place and the checksum of each trajectory
// flushed   the usual design: a dataset for each trajectory in an open HDF5 file, which is flushed
//           after each batch of eight
#include "archive/hdf5/handle.hpp"
#include "archive/journal/read.hpp"
#include "archive/journal/writer.hpp"
#include "archive/trajectory/reader.hpp"
#include "archive/trajectory/writer.hpp"
#include "bench/run_program.hpp"
#include "core/error.hpp"

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <fmt/core.h>
#include <hdf5.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace culm::bench {
namespace {

namespace fs = std::filesystem;
using archive::checked;

constexpr hsize_t samples = 2500;
constexpr int spheres = 56;
constexpr hsize_t numbers = samples * spheres * 3;
const char* const identity = "bench";

/// No two trajectories share a number.
std::vector<double> trajectory(std::int64_t point) {
    std::vector<double> values(numbers);
    for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = static_cast<double>(point) + 1.0 / static_cast<double>(k + 3);
    return values;
}

/// A writer that reports each committed point, and a reader of what a killed one has left. The
/// reader returns nothing if a trajectory cannot be read.
struct Design {
    const char* name;
    std::function<void(const fs::path& folder, const std::function<void(std::int64_t)>& commit)>
        write_on;
    std::function<std::function<std::optional<std::vector<double>>(std::int64_t)>(const fs::path&)>
        open;
};

constexpr std::array<hsize_t, 3> shape{samples, spheres, 3};

std::string dataset_name(std::int64_t number) {
    return fmt::format("trajectory_{:04}", number);
}

archive::StudyDescription description() {
    archive::StudyDescription study;
    study.stored.positions = true;
    for (hsize_t k = 0; k < samples; ++k)
        study.times.push_back(1e-4 * static_cast<double>(k));
    study.spheres = spheres;
    return study;
}

void write_reserved(const fs::path& folder, const std::function<void(std::int64_t)>& commit) {
    constexpr std::int64_t expected = 100; // a file has room for a quarter
    const archive::StudyDescription study = description();
    archive::JournalWriter journal(folder / "rank-00000.culmj", identity);
    archive::TrajectoryWriter trajectories(folder, 0, study, expected);
    for (std::int64_t point = 0;; ++point) {
        archive::PointRecord record;
        record.point = point;
        record.completed = true;
        record.trajectory = trajectories.write(trajectory(point));
        journal.append(record);
        commit(point);
    }
}

std::optional<std::vector<double>> read_dataset(const fs::path& path, const std::string& name) {
    const archive::FileHandle file(
        checked(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), "open", path));
    const archive::DatasetHandle dataset(H5Dopen2(file.get(), name.c_str(), H5P_DEFAULT));
    std::vector<double> values(numbers);
    if (!dataset.is_open() ||
        H5Dread(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
        return std::nullopt;
    return values;
}

std::function<std::optional<std::vector<double>>(std::int64_t)>
open_reserved(const fs::path& folder) {
    const auto scans = archive::scan_journal_folder(folder, identity);
    auto index = std::make_shared<archive::JournalIndex>(scans);
    auto files = std::make_shared<archive::TrajectoryFolder>(folder);
    return [index, files](std::int64_t point) -> std::optional<std::vector<double>> {
        const auto record = index->find_record(point);
        if (!record)
            return std::nullopt;
        return files->read(*record->trajectory);
    };
}

void write_flushed(const fs::path& folder, const std::function<void(std::int64_t)>& commit) {
    constexpr std::int64_t batch = 8;
    fs::create_directories(folder);
    const fs::path path = folder / "rank-00000.h5";
    const archive::FileHandle file(
        checked(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), "create", path));
    const archive::DataspaceHandle space(H5Screate_simple(3, shape.data(), nullptr));
    for (std::int64_t point = 0;; ++point) {
        const archive::DatasetHandle dataset(
            checked(H5Dcreate2(file.get(), dataset_name(point).c_str(), H5T_IEEE_F64LE, space.get(),
                               H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                    "create a dataset", path));
        checked(H5Dwrite(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                         trajectory(point).data()),
                "write", path);
        if ((point + 1) % batch != 0)
            continue;
        checked(H5Fflush(file.get(), H5F_SCOPE_GLOBAL), "flush", path);
        for (std::int64_t done = point + 1 - batch; done <= point; ++done)
            commit(done);
    }
}

std::function<std::optional<std::vector<double>>(std::int64_t)>
open_flushed(const fs::path& folder) {
    const fs::path path = folder / "rank-00000.h5";
    checked(H5Fclose(checked(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), "open", path)),
            "close", path);
    return [path](std::int64_t point) { return read_dataset(path, dataset_name(point)); };
}

struct Outcome {
    std::int64_t kills = 0;
    std::int64_t committed = 0;
    std::int64_t lost = 0;
    std::int64_t unreadable_files = 0;
    double seconds = 0.0; ///< until the kills
};

/// Starts a writer, kills it after the delay, and returns the points that it has committed.
std::vector<std::int64_t> killed(const Design& design, const fs::path& folder,
                                 std::chrono::microseconds delay) {
    std::array<int, 2> pipe{};
    if (::pipe(pipe.data()) != 0)
        throw core::StorageError("no pipe");
    const pid_t child = ::fork();
    if (child == 0) {
        ::close(pipe[0]);
        design.write_on(folder, [&](std::int64_t point) {
            if (::write(pipe[1], &point, sizeof(point)) != sizeof(point))
                ::_exit(1);
        });
        ::_exit(0);
    }
    ::close(pipe[1]);
    std::this_thread::sleep_for(delay);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    std::vector<std::int64_t> points;
    for (std::int64_t point = 0; ::read(pipe[0], &point, sizeof(point)) == sizeof(point);)
        points.push_back(point);
    ::close(pipe[0]);
    return points;
}

Outcome kill_many(const Design& design, const fs::path& scratch, int kills) {
    const archive::Hdf5Silence silence;
    std::mt19937 random(1);
    std::uniform_int_distribution<int> microseconds(30'000, 330'000);
    Outcome outcome;
    for (; outcome.kills < kills; ++outcome.kills) {
        fs::remove_all(scratch);
        const std::chrono::microseconds delay(microseconds(random));
        const std::vector<std::int64_t> points = killed(design, scratch, delay);
        outcome.committed += static_cast<std::int64_t>(points.size());
        outcome.seconds += std::chrono::duration<double>(delay).count();
        if (points.empty())
            continue;
        std::int64_t lost = 0;
        try {
            const auto read = design.open(scratch);
            for (const std::int64_t point : points)
                lost += read(point) == trajectory(point) ? 0 : 1;
        } catch (const core::StorageError&) {
            ++outcome.unreadable_files;
            lost = static_cast<std::int64_t>(points.size());
        }
        outcome.lost += lost;
    }
    fs::remove_all(scratch);
    return outcome;
}

void compare(const fs::path& scratch, int kills) {
    fmt::print("{} samples of {} spheres, {:.2f} MB a trajectory\n\n"
               "| design | kills | committed | lost | unreadable files | trajectories/s |\n"
               "|---|---:|---:|---:|---:|---:|\n",
               samples, spheres, 8e-6 * static_cast<double>(numbers));
    for (const Design& design : {Design{"reserved", &write_reserved, &open_reserved},
                                 Design{"flushed", &write_flushed, &open_flushed}}) {
        const Outcome outcome = kill_many(design, scratch, kills);
        fmt::print("| {} | {} | {} | {} | {} | {:.0f} |\n", design.name, outcome.kills,
                   outcome.committed, outcome.lost, outcome.unreadable_files,
                   static_cast<double>(outcome.committed) / outcome.seconds);
    }
}

} // namespace
} // namespace culm::bench

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fputs("use: bench_trajectory_designs SCRATCH_FOLDER KILLS\n", stderr);
        return 2;
    }
    return culm::bench::run_program([argv] {
        culm::bench::compare(std::filesystem::path(argv[1]) / "designs", std::stoi(argv[2]));
    });
}
