// SPDX-License-Identifier: BSD-3-Clause
// Heap blocks at multiples of 32 bytes, the size of an AVX register.
//
// Eigen sums a vector from the first element that is aligned to its registers. malloc() aligns to
// 16 bytes, so the order of a sum, and with it the last digits of every fit, depended on where the
// heap had put the vector: on the number of ranks, or on the length of an option. The linker
// replaces malloc() and realloc() in culm's own objects by these (cmake/CulmTargets.cmake); blocks
// are freed by free() as before, also by libraries. Eigen's own alignment stays that of the
// packaged libraries.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>

#include <malloc.h>

namespace {

void* aligned_block(std::size_t size) {
    constexpr std::size_t alignment = 32;
    if (size > static_cast<std::size_t>(-1) - alignment)
        return nullptr;
    return std::aligned_alloc(alignment, (std::max<std::size_t>(size, 1) + alignment - 1) /
                                             alignment * alignment);
}

} // namespace

// NOLINTBEGIN(bugprone-reserved-identifier): the linker's option --wrap gives these names.
extern "C" void* __wrap_malloc(std::size_t size);
extern "C" void* __wrap_realloc(void* block, std::size_t size);

extern "C" void* __wrap_malloc(std::size_t size) {
    return aligned_block(size);
}

extern "C" void* __wrap_realloc(void* block, std::size_t size) {
    void* const larger = aligned_block(size);
    if (block != nullptr && larger != nullptr) {
        std::memcpy(larger, block, std::min(size, ::malloc_usable_size(block)));
        std::free(block);
    }
    return larger;
}
// NOLINTEND(bugprone-reserved-identifier)

void* operator new(std::size_t size) {
    if (void* const block = aligned_block(size))
        return block;
    throw std::bad_alloc();
}

void operator delete(void* block) noexcept {
    std::free(block);
}

void operator delete(void* block, std::size_t) noexcept {
    std::free(block);
}
