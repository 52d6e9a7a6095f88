#pragma once

#include <cstddef>

namespace weft {

/// Asks the kernel to back memory of megabytes by large pages: page faults took half of the set-up
/// of a million triangles (benchmarks/journal/2026-11-two-cores.md). Does nothing where there are
/// none, or for less than a megabyte.
void ask_for_large_pages(void* memory, std::size_t bytes) noexcept;

}  // namespace weft
