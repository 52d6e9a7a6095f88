#include "weft/exec/large_pages.hpp"

#include <cstdint>

#if defined(__linux__)
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace weft {

void ask_for_large_pages(void* memory, std::size_t bytes) noexcept {
#if defined(__linux__)
  constexpr std::size_t least = std::size_t{1} << 20;
  if (memory == nullptr || bytes < least) return;
  static const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = (begin + page - 1) / page * page;
  // An advice: without it all works as before.
  static_cast<void>(madvise(reinterpret_cast<void*>(first), begin + bytes - first, MADV_HUGEPAGE));
#else
  static_cast<void>(memory);
  static_cast<void>(bytes);
#endif
}

}  // namespace weft
