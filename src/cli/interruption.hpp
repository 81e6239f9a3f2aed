// SPDX-License-Identifier: BSD-3-Clause
// The early end of a command that keeps what it has computed: signals, the walltime, and the
// results of items, so that the command started again with --resume computes only the others.
#pragma once

#include "archive/journal/read.hpp"
#include "archive/journal/writer.hpp"
#include "farm/communicator.hpp"
#include "farm/item_map.hpp"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace culm::cli {

/// From now on, signals by which a person or a batch system asks a run to stop are recorded and do
/// not end the program. A write beyond a file-size limit becomes an error and does not kill the
/// process (SIGXFSZ is ignored).
void watch_stop_signals();
[[nodiscard]] bool has_stop_signal();

/// FarmOptions::stop_requested: true after a stop signal. Rank 0 says at once that `what` is kept
/// in `folder`, because mpirun kills the ranks a second after it has passed on Ctrl-C as SIGTERM.
[[nodiscard]] std::function<bool()> stop_after_signal(const farm::Communicator* communicator,
                                                      const std::string& what,
                                                      const std::string& folder);

/// The time at which a run must have ended: --walltime, or the limit of the batch system.
struct RunDeadline {
    farm::Clock::time_point time; ///< on this rank's clock
    std::string text;             ///< the limit of the run, for people
};

/// The limit `walltime`, counted from `start`; if it is empty, rank 0 asks the batch system. A
/// fiftieth of the time, at least 1 s and at most 60 s, is reserved for an orderly end. Nothing if
/// there is no limit. Throws core::InputError on every rank. Collective.
[[nodiscard]] std::optional<RunDeadline> run_deadline(const std::string& walltime,
                                                      farm::Clock::time_point start,
                                                      const farm::Communicator* communicator);

/// The file unfinished.culmj in a folder, on rank 0. A value is stored as the numbers of a point:
/// its length in bytes, then eight bytes in each number.
class KeptItems {
  public:
    /// `identity`: the inputs, the options and the program, in lines. Throws core::InputError if
    /// the file exists and `resumes` is false, or if it has another identity.
    KeptItems(const std::filesystem::path& folder, const std::string& identity, bool resumes);

    [[nodiscard]] std::size_t size() const { return index_.size(); }
    [[nodiscard]] farm::ItemStore store();
    /// The command is complete: deletes the file.
    void remove();

  private:
    archive::JournalWriter writer_;
    archive::JournalIndex index_;
};

} // namespace culm::cli
