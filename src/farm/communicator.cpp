// SPDX-License-Identifier: BSD-3-Clause
#include "farm/communicator.hpp"

#include "core/error.hpp"
#include "farm/mpi_calls.hpp"

#include <numeric>
#include <utility>

namespace culm::farm {

namespace {

template <class Container>
Container broadcast_container(const CommunicatorHandle& comm, Container content, int root) {
    // Every rank receives the length as 64 bits and checks it in the same way, so none is left
    // waiting.
    auto length = static_cast<std::uint64_t>(content.size());
    check_mpi(MPI_Bcast(&length, 1, MPI_UINT64_T, root, comm.mpi), "MPI_Bcast");
    const int count = message_length(length);
    content.resize(length);
    check_mpi(MPI_Bcast(content.data(), count, MPI_BYTE, root, comm.mpi), "MPI_Bcast");
    return content;
}

/// The message that bytes_on_root broadcasts.
struct RootOutcome {
    enum class Kind { Answer, InputError, StorageError };
    Kind kind = Kind::Answer;
    Bytes answer;
    std::string error;
};

RootOutcome outcome_of(const std::function<Bytes()>& action) {
    try {
        return {RootOutcome::Kind::Answer, action(), {}};
    } catch (const core::InputError& error) {
        return {RootOutcome::Kind::InputError, {}, error.what()};
    } catch (const core::StorageError& error) {
        return {RootOutcome::Kind::StorageError, {}, error.what()};
    }
}

} // namespace

CommunicatorHandle::CommunicatorHandle(MPI_Comm parent) {
    check_mpi(MPI_Comm_dup(parent, &mpi), "MPI_Comm_dup");
    check_mpi(MPI_Comm_set_errhandler(mpi, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
    check_mpi(MPI_Comm_rank(mpi, &rank), "MPI_Comm_rank");
    check_mpi(MPI_Comm_size(mpi, &size), "MPI_Comm_size");
}

CommunicatorHandle::~CommunicatorHandle() {
    int is_finalized = 0;
    MPI_Finalized(&is_finalized);
    if (is_finalized == 0)
        MPI_Comm_free(&mpi);
}

Communicator::Communicator(std::unique_ptr<CommunicatorHandle> handle)
    : handle_(std::move(handle)) {}
Communicator::~Communicator() = default;
Communicator::Communicator(Communicator&&) noexcept = default;
Communicator& Communicator::operator=(Communicator&&) noexcept = default;

Communicator Communicator::world() {
    return Communicator(std::make_unique<CommunicatorHandle>(MPI_COMM_WORLD));
}

Communicator Communicator::duplicate() const {
    return Communicator(std::make_unique<CommunicatorHandle>(handle_->mpi));
}

int Communicator::rank() const {
    return handle_->rank;
}

int Communicator::size() const {
    return handle_->size;
}

void Communicator::barrier() const {
    check_mpi(MPI_Barrier(handle_->mpi), "MPI_Barrier");
}

std::string Communicator::broadcast(std::string text, int root) const {
    return broadcast_container(*handle_, std::move(text), root);
}

Bytes Communicator::broadcast(Bytes bytes, int root) const {
    return broadcast_container(*handle_, std::move(bytes), root);
}

std::vector<std::string> Communicator::gather(const std::string& text, int root) const {
    const bool is_root = rank() == root;
    const auto ranks = static_cast<std::size_t>(size());
    const auto length = static_cast<std::uint64_t>(text.size());
    std::vector<std::uint64_t> lengths(ranks);
    check_mpi(
        MPI_Allgather(&length, 1, MPI_UINT64_T, lengths.data(), 1, MPI_UINT64_T, handle_->mpi),
        "MPI_Allgather");
    // All ranks know all lengths, so all of them refuse a total that exceeds MPI's int counts.
    (void)message_length(std::accumulate(lengths.begin(), lengths.end(), std::uint64_t{0}));
    const std::vector<int> counts(lengths.begin(), lengths.end());
    std::vector<int> offsets(ranks);
    std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
    const int total = offsets.back() + counts.back();
    std::string joined(is_root ? static_cast<std::size_t>(total) : 0, '\0');
    check_mpi(MPI_Gatherv(text.data(), static_cast<int>(length), MPI_BYTE, joined.data(),
                          counts.data(), offsets.data(), MPI_BYTE, root, handle_->mpi),
              "MPI_Gatherv");
    std::vector<std::string> texts;
    for (std::size_t r = 0; is_root && r < ranks; ++r)
        texts.push_back(joined.substr(static_cast<std::size_t>(offsets[r]), lengths[r]));
    return texts;
}

bool Communicator::is_true_anywhere(bool value) const {
    const int mine = value ? 1 : 0;
    int any = 0;
    check_mpi(MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_LOR, handle_->mpi), "MPI_Allreduce");
    return any != 0;
}

Bytes bytes_on_root(const Communicator* communicator, const std::function<Bytes()>& action) {
    RootOutcome outcome;
    if (communicator == nullptr || communicator->rank() == 0)
        outcome = outcome_of(action);
    if (communicator != nullptr)
        outcome = core::decoded<RootOutcome>(communicator->broadcast(core::encoded(outcome)));
    if (outcome.kind == RootOutcome::Kind::InputError)
        throw core::InputError(outcome.error);
    if (outcome.kind == RootOutcome::Kind::StorageError)
        throw core::StorageError(outcome.error);
    return std::move(outcome.answer);
}

} // namespace culm::farm
