// SPDX-License-Identifier: BSD-3-Clause
#include "archive/hdf5/handle.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

namespace culm::archive {

namespace {

struct Reason {
    std::string innermost = "HDF5 gives no reason";
    bool is_lock = false;
};

herr_t visit_error(unsigned depth, const H5E_error2_t* error, void* data) noexcept {
    auto& reason = *static_cast<Reason*>(data);
    const std::string_view text = error->desc == nullptr ? "" : error->desc;
    // An upward walk begins at the innermost call, which knows the cause; its callers only repeat
    // that they failed.
    if (depth == 0 && !text.empty())
        reason.innermost = text;
    // HDF5 has no separate error code for a refused lock, and the text differs between versions.
    reason.is_lock |= text.find("lock the file") != std::string_view::npos ||
                      text.find("lock file") != std::string_view::npos;
    return 0;
}

} // namespace

std::string hdf5_reason() {
    Reason reason;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, &visit_error, &reason);
    if (reason.innermost == "filter returned failure during read") // all that HDF5 1.14 says
        reason.innermost = "wrong checksum or compressed data";
    if (reason.is_lock)
        reason.innermost += " (another process may have the file open)";
    return reason.innermost;
}

void throw_hdf5_error(std::string_view action, const std::filesystem::path& path) {
    throw core::StorageError(
        fmt::format("{}: cannot {}: {}", path.string(), action, hdf5_reason()));
}

} // namespace culm::archive
