// SPDX-License-Identifier: BSD-3-Clause
#include "farm/on_root.hpp"

#include "core/error.hpp"

#include <utility>

namespace culm::farm {

std::string on_root(const Communicator* communicator, const std::function<std::string()>& action) {
    std::string answer; // a letter that tells what follows: the answer or one of two errors
    if (communicator == nullptr || communicator->rank() == 0) {
        try {
            answer = action();
            answer.insert(answer.begin(), '=');
        } catch (const core::InputError& error) {
            answer = std::string("i") + error.what();
        } catch (const core::StorageError& error) {
            answer = std::string("s") + error.what();
        }
    }
    if (communicator != nullptr)
        answer = communicator->broadcast(std::move(answer));
    if (answer.front() == 'i')
        throw core::InputError(answer.substr(1));
    if (answer.front() == 's')
        throw core::StorageError(answer.substr(1));
    return answer.substr(1);
}

} // namespace culm::farm
