// SPDX-License-Identifier: BSD-3-Clause
#include "farm/mailbox.hpp"

#include "farm/mpi_calls.hpp"

#include <utility>

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

namespace culm::farm {

namespace {

bool has_left(MPI_Request& request) {
    int is_complete = 0;
    check_mpi(MPI_Test(&request, &is_complete, MPI_STATUS_IGNORE), "MPI_Test");
    return is_complete != 0;
}

} // namespace

Mailbox::~Mailbox() {
    // Messages have left by now, except after an error. Those leak: MPI may still read them.
    for (std::unique_ptr<Pending>& pending : pending_) {
        MPI_Request_free(&pending->request);
#ifdef __SANITIZE_ADDRESS__
        __lsan_ignore_object(pending.get()); // and all that it points to
#endif
        static_cast<void>(pending.release());
    }
}

void Mailbox::post(int destination, MessageKind kind, Bytes bytes) {
    const int size = message_length(bytes.size());
    // MPI reads the buffer until the request is complete, so it must keep its address while the
    // list grows.
    pending_.push_back(std::make_unique<Pending>(Pending{std::move(bytes), MPI_REQUEST_NULL}));
    Pending& pending = *pending_.back();
    const int code =
        MPI_Isend(pending.bytes.data(), size, MPI_BYTE, destination, static_cast<int>(kind),
                  communicator_.handle().mpi, &pending.request);
    if (code != MPI_SUCCESS) {
        pending_.pop_back();
        check_mpi(code, "MPI_Isend");
    }
    // Short messages have left already.
    if (has_left(pending.request))
        pending_.pop_back();
}

bool Mailbox::is_flushed() {
    std::erase_if(pending_, [](const auto& pending) { return has_left(pending->request); });
    return pending_.empty();
}

std::optional<Message> Mailbox::receive(int source) {
    const MPI_Comm comm = communicator_.handle().mpi;
    int has_arrived = 0;
    MPI_Status status;
    check_mpi(MPI_Iprobe(source, MPI_ANY_TAG, comm, &has_arrived, &status), "MPI_Iprobe");
    if (has_arrived == 0)
        return std::nullopt;
    int size = 0;
    check_mpi(MPI_Get_count(&status, MPI_BYTE, &size), "MPI_Get_count");
    Message message{status.MPI_SOURCE, static_cast<MessageKind>(status.MPI_TAG),
                    Bytes(static_cast<std::size_t>(size))};
    check_mpi(MPI_Recv(message.bytes.data(), size, MPI_BYTE, status.MPI_SOURCE, status.MPI_TAG,
                       comm, MPI_STATUS_IGNORE),
              "MPI_Recv");
    return message;
}

} // namespace culm::farm
