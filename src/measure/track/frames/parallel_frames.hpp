// SPDX-License-Identifier: BSD-3-Clause
// Distributes independent work over threads; errors are those that a serial loop would give.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace culm::measure {

/// Keeps the error of the smallest index; callable from several threads.
class FirstError {
  public:
    void keep(std::size_t index) {
        const std::scoped_lock lock(mutex_);
        if (error_ == nullptr || index < index_) {
            index_ = index;
            error_ = std::current_exception();
        }
    }
    void rethrow() const {
        if (error_ != nullptr)
            std::rethrow_exception(error_);
    }

  private:
    std::mutex mutex_;
    std::size_t index_ = 0;
    std::exception_ptr error_;
};

/// Runs `body` on `threads` threads, including the calling one, and waits for all.
template <class Body>
void on_threads(int threads, const Body& body) {
    std::vector<std::jthread> others;
    for (int t = 1; t < threads; ++t)
        others.emplace_back(body);
    body();
}

/// Calls work(0) … work(count − 1), each once, from `threads` threads. All are called even if one
/// throws; then the error of the smallest index is thrown.
template <class Work>
void for_each_index(std::size_t count, int threads, const Work& work) {
    std::atomic<std::size_t> next{0};
    FirstError error;
    on_threads(threads, [&] {
        for (std::size_t i = next++; i < count; i = next++) {
            try {
                work(i);
            } catch (...) {
                error.keep(i);
            }
        }
    });
    error.rethrow();
}

} // namespace culm::measure
