#include "weft/kernels/respond/remember.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// All levels, of vertices that zones move and of others.
template <bool Raise>
struct RecordCase {
  using Scalar = float;
  static constexpr Index count = 1000;
  std::vector<unsigned char> moved, touched;

  RecordCase() {
    for (Index v = 0; v < count; ++v) {
      moved.push_back(v % 3 == 0 ? 1 : 0);
      touched.push_back(static_cast<unsigned char>(v % 57 + (v % 2 == 0 ? 128 : 0)));
    }
  }

  Outputs compute(Device& device, Index parts) const {
    const auto m = upload(device, moved), t = upload(device, touched);
    for (const auto& [begin, size] : parts_of(count, parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             RespondRemember{m.span().subspan(b, n), Raise, t.span().subspan(b, n)});
    }
    return {output("touched", download(t))};
  }

  Outputs reference() const {
    std::vector<unsigned char> after;
    for (std::size_t v = 0; v < touched.size(); ++v) {
      int level = touched[v] % 128;
      if (moved[v] == 1 && Raise)
        level = std::min(56, level + 8);
      else
        level = std::max(0, level - 1);
      after.push_back(static_cast<unsigned char>(128 * moved[v] + level));
    }
    return {output("touched", after)};
  }
};

using Cases = testing::Types<RecordCase<true>, RecordCase<false>>;
INSTANTIATE_TYPED_TEST_SUITE_P(RespondRemember, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
