// SPDX-License-Identifier: BSD-3-Clause
// Point-to-point messages of the farm; neither sending nor polling blocks.
#pragma once

#include "farm/communicator.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include <mpi.h>

namespace culm::farm {

/// The values are the MPI tags.
enum class MessageKind : int {
    Report = 1, ///< worker to rank 0: a range is finished
    Failure,    ///< worker to rank 0: all ranks must stop, with the reason
    Stop,       ///< both ways: a stop was requested; to rank 0, whether by the deadline
    Started,    ///< worker to rank 0: its first message of this map
    Farewell,   ///< worker to rank 0: its last message of this map
    Assign,     ///< rank 0 to worker: a range to compute
    Summary,    ///< rank 0 to worker: the map is over
};

struct Message {
    int source = 0;
    MessageKind kind = MessageKind::Started;
    Bytes bytes;
};

/// Waits for messages at growing intervals, so that other processes on the same core can
/// work.
class Backoff {
  public:
    void pause() {
        if (yields_ < max_yields) {
            ++yields_;
            std::this_thread::yield();
            return;
        }
        std::this_thread::sleep_for(sleep_);
        sleep_ = std::min(2 * sleep_, max_sleep);
    }

    void reset() { *this = Backoff(); }

  private:
    /// An answer of a rank that is not busy arrives within some 5 µs; a yield takes below 1 µs.
    static constexpr int max_yields = 50;
    static constexpr std::chrono::microseconds min_sleep{20};
    static constexpr std::chrono::microseconds max_sleep{1000};

    int yields_ = 0;
    std::chrono::microseconds sleep_ = min_sleep;
};

class Mailbox {
  public:
    /// On a duplicate of `communicator`. Collective.
    explicit Mailbox(const Communicator& communicator) : communicator_(communicator.duplicate()) {}
    ~Mailbox();
    Mailbox(const Mailbox&) = delete;
    Mailbox& operator=(const Mailbox&) = delete;

    [[nodiscard]] int rank() const { return communicator_.rank(); }
    [[nodiscard]] int size() const { return communicator_.size(); }

    /// Starts to send; the mailbox keeps the bytes until they have left.
    void post(int destination, MessageKind kind, Bytes bytes);

    /// A message that has arrived, from any rank or from `source`; messages of one rank keep the
    /// order of sending.
    [[nodiscard]] std::optional<Message> receive(int source = MPI_ANY_SOURCE);

    /// Whether all posted messages have left. Makes progress on them.
    [[nodiscard]] bool is_flushed();

  private:
    struct Pending {
        Bytes bytes;
        MPI_Request request = MPI_REQUEST_NULL;
    };

    Communicator communicator_;
    std::vector<std::unique_ptr<Pending>> pending_;
};

} // namespace culm::farm
