// SPDX-License-Identifier: BSD-3-Clause
#include "cli/stop_signal.hpp"

#include <csignal>
#include <initializer_list>

namespace culm::cli {
namespace {

// A signal handler can reach nothing but a variable of static storage.
volatile std::sig_atomic_t stop_signal = 0;

void remember(int signal) {
    stop_signal = signal;
}

} // namespace

void watch_stop_signals() {
    for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGUSR2})
        std::signal(signal, remember);
    std::signal(SIGXFSZ, SIG_IGN);
}

bool stop_signal_arrived() {
    return stop_signal != 0;
}

} // namespace culm::cli
