#include "host/base/bytes.hpp"

#include <gtest/gtest.h>

#include "weft/error.hpp"

namespace weft {
namespace {

using Lists = std::vector<std::vector<double>>;

template <class T>
T unpacked(const std::string& bytes) {
  T value{};
  Unpacker unpacker(bytes, "file", "field", "whole values");
  unpacker.get(value);
  unpacker.end();
  return value;
}

TEST(Packer, ListsComeBack) {
  Packer packer;
  packer.put(7);
  packer.put(Lists{{1, 2}, {}, {3}});
  packer.put(std::vector<unsigned char>{});
  Unpacker unpacker(packer.bytes, "file", "field", "whole values");
  int number = 0;
  Lists lists;
  std::vector<unsigned char> none{1};
  unpacker.get(number);
  unpacker.get(lists);
  unpacker.get(none);
  unpacker.end();
  EXPECT_EQ(number, 7);
  EXPECT_EQ(lists, (Lists{{1, 2}, {}, {3}}));
  EXPECT_TRUE(none.empty());
}

TEST(Packer, EmptyListsTakeNoMoreRoomThanTheirNumbers) {
  Packer packer;
  packer.put(Lists(5));
  EXPECT_EQ(packer.bytes.size(), 6 * sizeof(std::uint64_t));
  EXPECT_EQ(unpacked<Lists>(packer.bytes), Lists(5));
}

TEST(Unpacker, RefusesWhatIsNotWhole) {
  Packer packer;
  packer.put(Lists{{1, 2}, {3}});
  const std::string whole = packer.bytes;
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THROW(unpacked<Lists>(whole.substr(0, size)), SceneError) << size;
  EXPECT_THROW(unpacked<Lists>(whole + "x"), SceneError);
  EXPECT_EQ(unpacked<Lists>(whole), (Lists{{1, 2}, {3}}));
}

TEST(Unpacker, RefusesCountsBeyondTheBytes) {
  Packer packer;
  packer.put(~std::uint64_t{0});
  EXPECT_THROW(unpacked<std::vector<double>>(packer.bytes), SceneError);
  EXPECT_THROW(unpacked<Lists>(packer.bytes), SceneError);
}

}  // namespace
}  // namespace weft
