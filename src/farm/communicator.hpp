// SPDX-License-Identifier: BSD-3-Clause
// An owned MPI communicator with checked, typed calls; the header is free of mpi.h.
#pragma once

#include "farm/wire.hpp"

#include <memory>
#include <string>
#include <vector>

namespace culm::farm {

/// The MPI object behind a Communicator (communicator_handle.hpp).
struct CommunicatorHandle;

/// A duplicate of its own: messages sent through it never meet those of other communicators.
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

    /// The text that `root` holds, on every rank. Collective.
    [[nodiscard]] std::string broadcast(std::string text, int root = 0) const;

    /// The bytes that `root` holds, on every rank. Collective.
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

} // namespace culm::farm
