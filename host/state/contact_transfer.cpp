#include "host/state/contact_transfer.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "host/base/buckets.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

/// Numbers of faces or edges by their vertices.
template <class List, std::size_t N>
class Numbers {
 public:
  /// @param list [items] with vertices v
  Numbers(const std::vector<List>& list, Index vertex_count)
      : list_(list),
        lowest_(buckets_by(static_cast<Index>(list.size()), vertex_count,
                           [&](Index i) { return key_of(list[at(i)].v)[0]; })) {}

  /// Of several with these vertices the last; -1: there is none.
  /// @param v any order; a negative one has none
  Index find(const std::array<Index, N>& v) const {
    const std::array<Index, N> key = key_of(v.data());
    if (key[0] < 0) return -1;
    for (const Index* i = lowest_.end(key[0]); i != lowest_.begin(key[0]);)
      if (key_of(list_[at(*--i)].v) == key) return *i;
    return -1;
  }

 private:
  static std::array<Index, N> key_of(const Index* v) {
    std::array<Index, N> key;
    std::copy(v, v + N, key.begin());
    std::sort(key.begin(), key.end());
    return key;
  }

  const std::vector<List>& list_;
  Buckets lowest_;
};

/// Contacts of one model in the numbers of another.
class ContactNumbers {
 public:
  /// @param vertex [vertices of from] number in `to`, -1: none
  ContactNumbers(const Model& from, const Model& to, const std::vector<Index>& vertex)
      : from_(from),
        to_(to),
        vertex_(vertex),
        faces_(to.triangles, to.vertex_count),
        edges_(to.edges, to.vertex_count) {}

  /// @return numbers below 0 where there is no such pair any more
  Pair face_pair(const Pair& pair) const {
    const Pair now{vertex_[at(pair.a)], face(pair.b)};
    if (now.a < 0 || now.b < 0) return {-1, -1};
    const Index* v = to_.triangles[at(now.b)].v;
    return std::find(v, v + 3, now.a) == v + 3 ? now : Pair{-1, -1};
  }
  Pair edge_pair(const Pair& pair) const {
    const Pair now{edge(pair.a), edge(pair.b)};
    if (now.a < 0 || now.b < 0) return {-1, -1};
    const Index* p = to_.edges[at(now.a)].v;
    const Index* q = to_.edges[at(now.b)].v;
    return std::find_first_of(p, p + 2, q, q + 2) == p + 2 ? now : Pair{-1, -1};
  }

 private:
  Index face(Index f) const {
    const Index* v = from_.triangles[at(f)].v;
    return faces_.find({vertex_[at(v[0])], vertex_[at(v[1])], vertex_[at(v[2])]});
  }
  Index edge(Index e) const {
    const Index* v = from_.edges[at(e)].v;
    return edges_.find({vertex_[at(v[0])], vertex_[at(v[1])]});
  }

  const Model& from_;
  const Model& to_;
  const std::vector<Index>& vertex_;
  Numbers<Tri, 3> faces_;
  Numbers<Edge, 2> edges_;
};

bool is_with_body(const Model& model, const Pair& pair, bool face) {
  // Of two edges the lower asks, and cloth has the lower numbers.
  if (!face) return pair.b >= model.cloth_edge_count;
  return pair.a >= model.cloth_vertex_count || pair.b >= model.cloth_triangle_count;
}

/// Adds what another contact leaves to the same pair.
template <class T>
void add(const ContactMemory<T>& other, ContactMemory<T>& sum) {
  const Vec3<T> n = sum.n + other.n;
  const T size = length(n);
  sum.normal_force += other.normal_force;
  sum.load += other.load;
  sum.sticking_force += other.sticking_force;
  sum.friction += other.friction;
  if (size > T(0)) sum.n = (T(1) / size) * n;
}

/// Puts contacts in the order of their pairs, each pair once.
template <class T>
void order(std::vector<ContactMemory<T>>& contacts) {
  // Stable: the sum of contacts that become one must not depend on the sort.
  std::stable_sort(contacts.begin(), contacts.end(), [](const auto& p, const auto& q) {
    return p.pair.a != q.pair.a ? p.pair.a < q.pair.a : p.pair.b < q.pair.b;
  });
  std::size_t last = 0;
  for (std::size_t i = 1; i < contacts.size(); ++i) {
    const bool same =
        contacts[i].pair.a == contacts[last].pair.a && contacts[i].pair.b == contacts[last].pair.b;
    if (same)
      add(contacts[i], contacts[last]);
    else
      contacts[++last] = contacts[i];
  }
  if (!contacts.empty()) contacts.resize(last + 1);
}

}  // namespace

template <class T>
void transfer_contacts(const Model& from, const StateSnapshot<T>& state,
                       const std::vector<Index>& vertex, const Model& to, bool keep_self,
                       StateSnapshot<T>& result) {
  result.contacts.clear();
  result.face_contacts = 0;
  if (state.contacts.empty()) return;
  const ContactNumbers numbers(from, to, vertex);
  std::vector<ContactMemory<T>> faces, edges;
  for (std::size_t i = 0; i < state.contacts.size(); ++i) {
    const bool face = static_cast<std::int64_t>(i) < state.face_contacts;
    ContactMemory<T> c = state.contacts[i];
    if (!keep_self && !is_with_body(from, c.pair, face)) continue;
    c.pair = face ? numbers.face_pair(c.pair) : numbers.edge_pair(c.pair);
    if (c.pair.a < 0) continue;
    if (!face && c.pair.a > c.pair.b) {  // the lower edge asks
      std::swap(c.pair.a, c.pair.b);
      c.n = -c.n;
      c.friction = -c.friction;
    }
    (face ? faces : edges).push_back(c);
  }
  order(faces);
  order(edges);
  result.face_contacts = static_cast<std::int64_t>(faces.size());
  result.contacts = std::move(faces);
  result.contacts.insert(result.contacts.end(), edges.begin(), edges.end());
}

template void transfer_contacts(const Model&, const StateSnapshot<float>&,
                                const std::vector<Index>&, const Model&, bool,
                                StateSnapshot<float>&);
template void transfer_contacts(const Model&, const StateSnapshot<double>&,
                                const std::vector<Index>&, const Model&, bool,
                                StateSnapshot<double>&);

}  // namespace weft
