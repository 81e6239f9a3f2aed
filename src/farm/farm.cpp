// SPDX-License-Identifier: BSD-3-Clause
#include "farm/farm.hpp"

#include "farm/mailbox.hpp"
#include "farm/map_call.hpp"

namespace culm::farm {

Farm::Farm() : alive_(1, true) {}

Farm::Farm(const Communicator& communicator)
    : mailbox_(communicator.size() > 1 ? std::make_unique<Mailbox>(communicator) : nullptr),
      alive_(static_cast<std::size_t>(communicator.size()), true) {}

Farm::~Farm() = default;

int Farm::rank() const {
    return mailbox_ ? mailbox_->rank() : 0;
}

int Farm::size() const {
    return mailbox_ ? mailbox_->size() : 1;
}

Summary Farm::map(std::span<const Batch> batches, const Work& work, const FarmOptions& options) {
    const MapCall call{
        batches, plan_order(batches), work, options, digest(batches), ++maps_, rank(), size()};
    if (rank() == 0)
        return coordinate(call, mailbox_.get(), alive_);
    return work_for_rank_0(call, *mailbox_);
}

} // namespace culm::farm
