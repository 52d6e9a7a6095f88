#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "weft/core/hd.hpp"
#include "weft/core/span.hpp"

namespace weft {

/// Which of many items are marked, a bit an item, counted so that the n-th marked one is found by
/// halving: marked items are passed on in their order without a list of them that would have to be
/// sized for the worst case.
struct Marks {
  static constexpr std::uint32_t word_items = 32;
  static constexpr std::uint32_t tile_words = 256;

  Span<std::uint32_t> words;        ///< bit k of word w stands for item 32 w + k
  Span<std::uint32_t> before_word;  ///< [words] marks of the words before it in its tile
  Span<std::uint32_t> before_tile;  ///< [tiles of words] marks before the tile
  Span<std::uint32_t> head;         ///< [2] number of words in use, number of marks

  WEFT_HD std::uint32_t words_in_use() const noexcept { return head[0]; }
  WEFT_HD std::uint32_t count() const noexcept { return head[1]; }
};

/// Words that hold the marks of some items.
WEFT_HD constexpr std::size_t mark_words(std::size_t items) noexcept {
  return (items + Marks::word_items - 1) / Marks::word_items;
}

/// Memory that the marks of up to so many items take, in numbers.
constexpr std::size_t marks_size(std::size_t items) noexcept {
  const std::size_t words = mark_words(items);
  return 2 * words + (words + Marks::tile_words - 1) / Marks::tile_words + 2;
}

/// Cuts marks of up to so many items off the front of `memory`.
/// @pre memory has marks_size(items) numbers
inline Marks take_marks(Span<std::uint32_t>& memory, std::size_t items) noexcept {
  const auto take = [&memory](std::size_t count) {
    const Span<std::uint32_t> front = memory.subspan(0, count);
    memory = memory.subspan(count, memory.size() - count);
    return front;
  };
  const std::size_t words = mark_words(items);
  Marks m;
  m.words = take(words);
  m.before_word = take(words);
  m.before_tile = take((words + Marks::tile_words - 1) / Marks::tile_words);
  m.head = take(2);
  return m;
}

/// Last of the numbers [begin, end) of an ascending list that is not above n.
/// @pre the first one is not
WEFT_HD inline std::uint32_t last_not_above(const Span<std::uint32_t>& list, std::uint32_t begin,
                                            std::uint32_t end, std::uint32_t n) noexcept {
  while (end - begin > 1) {
    const std::uint32_t middle = begin + (end - begin) / 2;
    if (list.data()[middle] <= n)
      begin = middle;
    else
      end = middle;
  }
  return begin;
}

/// The item of the n-th mark, counted from zero, in ascending order.
/// @pre the marks are counted, n < count()
WEFT_HD inline std::uint32_t nth_mark(const Marks& m, std::uint32_t n) noexcept {
  const std::uint32_t words = m.words_in_use();
  const std::uint32_t tiles = (words + Marks::tile_words - 1) / Marks::tile_words;
  const std::uint32_t tile = last_not_above(m.before_tile, 0, tiles, n);
  n -= m.before_tile.data()[tile];
  const std::uint32_t begin = tile * Marks::tile_words;
  const std::uint32_t end = begin + Marks::tile_words < words ? begin + Marks::tile_words : words;
  const std::uint32_t word = last_not_above(m.before_word, begin, end, n);
  n -= m.before_word.data()[word];
  std::uint32_t bits = m.words.data()[word];
  std::uint32_t bit = 0;
  for (std::uint32_t half = Marks::word_items / 2; half > 0; half /= 2) {
    const std::uint32_t low = bits & ((std::uint32_t{1} << half) - 1);
    const auto below = static_cast<std::uint32_t>(std::popcount(low));
    if (n < below) {
      bits = low;
      continue;
    }
    n -= below;
    bits >>= half;
    bit += half;
  }
  return word * Marks::word_items + bit;
}

/// Number of marks of items before `item`, which may be the end.
/// @pre the marks are counted
WEFT_HD inline std::uint32_t marks_before(const Marks& m, std::uint32_t item) noexcept {
  const std::uint32_t word = item / Marks::word_items;
  if (word >= m.words_in_use()) return m.count();
  const std::uint32_t below = (std::uint32_t{1} << item % Marks::word_items) - 1;
  return m.before_tile.data()[word / Marks::tile_words] + m.before_word.data()[word] +
         static_cast<std::uint32_t>(std::popcount(m.words.data()[word] & below));
}

}  // namespace weft
