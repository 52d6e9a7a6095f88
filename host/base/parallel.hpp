#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <exception>
#include <numeric>
#include <thread>
#include <vector>

namespace weft {

/// Threads for work on `items` items while a scene is set up: a power of two, 1 for little work.
/// Results must not depend on it.
inline unsigned setup_threads(std::size_t items) {
  if (items < 4096) return 1;
  return std::bit_floor(std::clamp(std::thread::hardware_concurrency(), 1u, 16u));
}

/// Calls body(n) for each n < threads, all at once, and returns when all are done.
/// @throws what the first of them threw
template <class Body>
void on_threads(unsigned threads, const Body& body) {
  std::vector<std::exception_ptr> errors(threads);
  const auto guarded = [&](unsigned n) {
    try {
      body(n);
    } catch (...) {
      errors[n] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (unsigned n = 1; n < threads; ++n) others.emplace_back(guarded, n);
    guarded(0);
  }
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

/// Calls body(i) for 0 <= i < count, in runs of neighbouring i on each of the threads.
template <class Body>
void for_each_index(unsigned threads, std::size_t count, const Body& body) {
  on_threads(threads, [&](unsigned n) {
    for (std::size_t i = count * n / threads; i < count * (n + 1) / threads; ++i) body(i);
  });
}

/// Sum of term(i) for 0 <= i < count on several threads. Blocks of fixed length are summed up
/// first, so that the bits do not depend on the threads.
template <class Term>
double sum_of(std::size_t count, const Term& term) {
  constexpr std::size_t length = 8192;
  std::vector<double> blocks((count + length - 1) / length);
  const unsigned threads = blocks.size() > 1 ? setup_threads(count) : 1;
  for_each_index(threads, blocks.size(), [&](std::size_t b) {
    double sum = 0;
    for (std::size_t i = b * length; i < std::min(count, (b + 1) * length); ++i) sum += term(i);
    blocks[b] = sum;
  });
  return std::accumulate(blocks.begin(), blocks.end(), 0.0);
}

}  // namespace weft
