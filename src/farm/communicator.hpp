// SPDX-License-Identifier: BSD-3-Clause
// An owned MPI communicator with checked, typed calls; the header is free of mpi.h.
#pragma once

#include "core/wire.hpp"

#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace culm::farm {

using core::Bytes;

/// The MPI object behind a Communicator (mpi_calls.hpp).
struct CommunicatorHandle;

/// Owns a duplicate communicator: its messages never mix with those of other communicators.
/// Every error of MPI is thrown as FarmError. Must be destroyed before the Environment.
class Communicator {
  public:
    /// Duplicate of MPI_COMM_WORLD. Collective.
    [[nodiscard]] static Communicator world();

    /// Collective.
    [[nodiscard]] Communicator duplicate() const;

    ~Communicator();
    Communicator(Communicator&&) noexcept;
    Communicator& operator=(Communicator&&) noexcept;
    Communicator(const Communicator&) = delete;
    Communicator& operator=(const Communicator&) = delete;

    [[nodiscard]] int rank() const;
    [[nodiscard]] int size() const;

    /// Returns when every rank has arrived. Collective.
    void barrier() const;

    /// Returns the text of `root` on every rank. Collective.
    [[nodiscard]] std::string broadcast(std::string text, int root = 0) const;

    /// Returns the bytes of `root` on every rank. Collective.
    [[nodiscard]] Bytes broadcast(Bytes bytes, int root = 0) const;

    /// On `root` the texts of all ranks, indexed by rank; elsewhere empty. Collective.
    [[nodiscard]] std::vector<std::string> gather(const std::string& text, int root = 0) const;

    /// Whether `value` is true on at least one rank; the same answer everywhere. Collective.
    [[nodiscard]] bool is_true_anywhere(bool value) const;

    [[nodiscard]] const CommunicatorHandle& handle() const { return *handle_; }

  private:
    explicit Communicator(std::unique_ptr<CommunicatorHandle> handle);

    std::unique_ptr<CommunicatorHandle> handle_;
};

/// on_root for an answer that consists of bytes.
[[nodiscard]] Bytes bytes_on_root(const Communicator* communicator,
                                  const std::function<Bytes()>& action);

/// Runs `action`, such as writing a file, on rank 0 only. Every rank receives its answer, of any
/// type that travels (core/wire.hpp), or the core::InputError or core::StorageError that it throws,
/// so that no rank waits for one that has failed. Other exceptions are not passed on.
/// `communicator` is null without MPI. Collective.
template <class Action, class Answer = std::invoke_result_t<Action>>
[[nodiscard]] Answer on_root(const Communicator* communicator, const Action& action) {
    return core::decoded<Answer>(
        bytes_on_root(communicator, [&action] { return core::encoded<Answer>(action()); }));
}

} // namespace culm::farm
