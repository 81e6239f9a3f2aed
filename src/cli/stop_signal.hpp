// SPDX-License-Identifier: BSD-3-Clause
// Signals by which a person or a batch system asks a run to stop.
#pragma once

namespace culm::cli {

/// From now on SIGINT, SIGTERM, SIGUSR1 and SIGUSR2 are remembered instead of ending the program,
/// and a write beyond a file-size limit is an error instead of a death (SIGXFSZ is ignored).
void watch_stop_signals();

/// Whether one of the stop signals has arrived.
[[nodiscard]] bool stop_signal_arrived();

} // namespace culm::cli
