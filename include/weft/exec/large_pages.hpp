#pragma once

#include <cstddef>

namespace weft {

/// Asks the kernel to back memory by large pages: page faults took half of the set-up of a million
/// triangles (benchmarks/journal/2026-11-two-cores.md). Buffers of devices do so; a program does
/// for its vectors if its operator new calls this, as that of `weft` does. Does nothing where there
/// are no such pages, or for less than a megabyte.
void ask_for_large_pages(void* memory, std::size_t bytes) noexcept;

}  // namespace weft
