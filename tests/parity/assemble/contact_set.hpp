#pragma once

#include <limits>

#include "tests/parity/support.hpp"
#include "weft/kernels/assemble/contacts.hpp"

namespace weft::parity {

/// Contacts of all kinds between random vertices, some of them obstacle's: pushing or apart,
/// sticking or sliding, with anchors.
template <class T>
struct ContactSet {
  static constexpr Index cloth = 400, vertices = 460;
  Random random;
  std::vector<Vec3<T>> positions, positions_t0;
  std::vector<Contact<T>> contacts;

  ContactSet(std::uint32_t seed, std::size_t count) : random(seed) {
    positions = random.vectors<T>(vertices, -0.1, 0.1);
    for (const Vec3<T>& x : positions) positions_t0.push_back(x + random.vector<T>(-0.01, 0.01));
    for (std::size_t n = 0; n < count; ++n) contacts.push_back(make());
  }
  Index vertex(Index bound) {
    return static_cast<Index>(random.uniform<double>(0, 1) * (bound - 1));
  }
  Vec3<T> unit() {
    // An axis, leaning by some degrees: exact in both precisions up to rounding of one product.
    Vec3<T> n = random.vector<T>(-0.125, 0.125);
    n[vertex(3)] = T(1);
    return (T(1) / length(n)) * n;
  }
  Contact<T> make() {
    Contact<T> c{};
    // A crowd around one vertex, which then has more entries than a row's threads.
    c.v[0] = contacts.size() % 10 == 0 ? 77 : vertex(cloth);
    for (int j = 1; j < 4; ++j) do
        c.v[j] = contacts.size() % 3 == 0 ? cloth + vertex(vertices - cloth) : vertex(cloth);
      while (c.v[j] == c.v[0] || (j > 1 && c.v[j] == c.v[1]) || (j > 2 && c.v[j] == c.v[2]));
    c.w[0] = T(1);
    c.w[1] = -random.uniform<T>(0.1, 0.5);
    c.w[2] = -random.uniform<T>(0.1, 0.4);
    c.w[3] = -(T(1) + c.w[1] + c.w[2]);
    c.n = unit();
    c.stiffness = random.uniform<T>(100, 200);
    c.hold = random.uniform<T>(50, 200);
    c.thickness = random.uniform<T>(0.001, 0.05);
    c.reach = random.uniform<T>(0.001, 0.05);
    c.yield = random.uniform<T>(0, 5);
    if (contacts.size() % 3 == 0) c.yield = std::numeric_limits<T>::infinity();
    c.friction = random.uniform<T>(0, 0.5);
    c.load = random.uniform<T>(0, 3);
    c.anchor = tangential(random.vector<T>(-0.01, 0.01), c.n);
    c.push = contacts.size() % 4 == 0 ? T(0) : c.stiffness;
    c.drag = c.push > T(0) ? random.uniform<T>(0, 100) : T(0);
    c.drag_limit = random.uniform<T>(0, 1);
    c.slide = contacts.size() % 2 == 0 ? Vec3<T>{} : unit();
    return c;
  }
};

/// Vertices with and without a level, among them those that a crowd of contacts has.
inline std::vector<unsigned char> levels(Index vertices) {
  std::vector<unsigned char> all;
  for (Index v = 0; v < vertices; ++v)
    all.push_back(static_cast<unsigned char>(v % 3 == 0 ? v % 57 : v % 2 == 0 ? 128 : 0));
  return all;
}

/// Whether a contact bears more than its yield and closes to less than four fifths of its reach.
inline bool plainly_crushed(const Contact<double>& c, double gap, double gap_t0) {
  return gap < 0.8 * c.reach && gap < 0.999 * gap_t0 && c.stiffness * (c.thickness - gap) > c.yield;
}
inline bool has_level(const Contact<double>& c, const std::vector<unsigned char>& touched) {
  return std::any_of(c.v, c.v + 4, [&](Index v) {
    return static_cast<std::size_t>(v) < touched.size() &&
           touched[static_cast<std::size_t>(v)] % 128 != 0;
  });
}

/// A contact with the same numbers in double.
template <class T>
Contact<double> in_double(const Contact<T>& c) {
  Contact<double> d{};
  for (int j = 0; j < 4; ++j) {
    d.v[j] = c.v[j];
    d.w[j] = double{c.w[j]};
  }
  d.pair = c.pair;
  d.n = vec_cast<double>(c.n);
  d.stiffness = double{c.stiffness};
  d.hold = double{c.hold};
  d.thickness = double{c.thickness};
  d.reach = double{c.reach};
  d.yield = double{c.yield};
  d.friction = double{c.friction};
  d.load = double{c.load};
  d.anchor = vec_cast<double>(c.anchor);
  d.push = double{c.push};
  d.drag = double{c.drag};
  d.drag_limit = double{c.drag_limit};
  d.slide = vec_cast<double>(c.slide);
  return d;
}
template <class T>
std::vector<Vec3<double>> in_double(const std::vector<Vec3<T>>& all) {
  std::vector<Vec3<double>> result;
  for (const Vec3<T>& v : all) result.push_back(vec_cast<double>(v));
  return result;
}

}  // namespace weft::parity
