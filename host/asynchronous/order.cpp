#include "host/asynchronous/order.hpp"

#include "weft/core/at.hpp"

#include <algorithm>
#include <numeric>

namespace weft {
namespace {

struct Graph {
  std::vector<std::size_t> offset;  ///< [vertices + 1]
  std::vector<Index> neighbour;

  std::size_t degree(Index v) const { return offset[at(v) + 1] - offset[at(v)]; }
};

Graph make_graph(Index count, const std::vector<Edge>& edges) {
  Graph g;
  g.offset.assign(at(count) + 1, 0);
  const auto counts = [&](const Edge& e) { return e.v[0] < count && e.v[1] < count; };
  for (const Edge& e : edges)
    if (counts(e))
      for (const Index v : e.v) ++g.offset[at(v) + 1];
  std::partial_sum(g.offset.begin(), g.offset.end(), g.offset.begin());
  g.neighbour.resize(g.offset.back());
  std::vector<std::size_t> next(g.offset.begin(), g.offset.end() - 1);
  for (const Edge& e : edges)
    if (counts(e))
      for (int k = 0; k < 2; ++k) g.neighbour[next[at(e.v[k])]++] = e.v[1 - k];
  return g;
}

}  // namespace

std::vector<Index> reverse_cuthill_mckee(Index count, const std::vector<Edge>& edges) {
  const Graph g = make_graph(count, edges);
  const auto fewer = [&](Index a, Index b) {
    return g.degree(a) != g.degree(b) ? g.degree(a) < g.degree(b) : a < b;
  };
  std::vector<Index> starts(at(count));
  std::iota(starts.begin(), starts.end(), 0);
  std::sort(starts.begin(), starts.end(), fewer);
  std::vector<unsigned char> seen(at(count), 0);
  std::vector<Index> order;
  order.reserve(at(count));
  for (const Index start : starts) {  // one for each part of the graph finds more
    if (seen[at(start)] != 0) continue;
    seen[at(start)] = 1;
    order.push_back(start);
    for (std::size_t head = order.size() - 1; head < order.size(); ++head) {
      const Index v = order[head];
      const std::size_t first_new = order.size();
      for (std::size_t k = g.offset[at(v)]; k < g.offset[at(v) + 1]; ++k) {
        const Index u = g.neighbour[k];
        if (seen[at(u)] != 0) continue;
        seen[at(u)] = 1;
        order.push_back(u);
      }
      std::sort(order.begin() + static_cast<std::ptrdiff_t>(first_new), order.end(), fewer);
    }
  }
  std::reverse(order.begin(), order.end());
  return order;
}

}  // namespace weft
