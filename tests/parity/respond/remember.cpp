#include "weft/kernels/respond/remember.hpp"

#include "tests/parity/support.hpp"

namespace weft::parity {
namespace {

/// All levels, of vertices that zones move, of vertices of crushed contacts, and of others.
template <Hardening hardening>
struct RecordCase {
  using Scalar = float;
  static constexpr Index count = 1000;
  std::vector<unsigned char> moved, crushed, in_jam, touched;

  RecordCase() {
    for (Index v = 0; v < count; ++v) {
      moved.push_back(v % 3 == 0 ? 1 : 0);
      crushed.push_back(v % 5 == 0 ? 1 : 0);
      in_jam.push_back(v % 10 == 0 ? 1 : 0);
      touched.push_back(static_cast<unsigned char>(v % 57 + (v % 2 == 0 ? 128 : 0)));
    }
  }

  Outputs compute(Device& device, Index parts) const {
    const auto m = upload(device, moved), t = upload(device, touched);
    const auto c = upload(device, crushed), j = upload(device, in_jam);
    for (const auto& [begin, size] : parts_of(count, parts)) {
      const auto b = static_cast<std::size_t>(begin), n = static_cast<std::size_t>(size);
      launch(device.compute(),
             RespondRemember{m.span().subspan(b, n), c.span().subspan(b, n), j.span().subspan(b, n),
                             hardening, t.span().subspan(b, n)});
    }
    return {output("touched", download(t))};
  }

  Outputs reference() const {
    std::vector<unsigned char> after;
    for (std::size_t v = 0; v < touched.size(); ++v) {
      int level = touched[v] % 128;
      bool jams = false;
      if (hardening == Hardening::jammed)
        jams = (level > 0 && moved[v] + crushed[v] > 0) || in_jam[v] == 1;
      if (hardening == Hardening::crushed) jams = (level > 0 && moved[v] == 1) || crushed[v] == 1;
      if (hardening == Hardening::all) jams = moved[v] + crushed[v] > 0;
      if (jams)
        level = std::min(56, level + 8);
      else
        level = std::max(0, level - 1);
      after.push_back(static_cast<unsigned char>(128 * moved[v] + level));
    }
    return {output("touched", after)};
  }
};

using Cases = testing::Types<RecordCase<Hardening::none>, RecordCase<Hardening::jammed>,
                             RecordCase<Hardening::crushed>, RecordCase<Hardening::all>>;
INSTANTIATE_TYPED_TEST_SUITE_P(RespondRemember, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
