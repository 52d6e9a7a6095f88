#include "host/implicit/mesh_rows.hpp"

#include <algorithm>

namespace weft {
namespace {

struct Entry {
  Index column;
  BlockSource source;
};

class MeshRowsBuilder {
 public:
  MeshRowsBuilder(const Model& model, const Partition& partition, int rank)
      : model_(model),
        begin_(partition.row_begin[static_cast<std::size_t>(rank)]),
        end_(partition.row_begin[static_cast<std::size_t>(rank) + 1]) {}

  MeshRows build() {
    choose_elements();
    list_corners();
    out_.slice_offset.push_back(0);
    out_.block_source_offset.push_back(0);
    std::vector<std::vector<Entry>> rows(static_cast<std::size_t>(mesh_slice));
    for (Index first = begin_; first < end_; first += mesh_slice) {
      for (Index lane = 0; lane < mesh_slice; ++lane)
        collect_row(first + lane, rows[static_cast<std::size_t>(lane)]);
      append_slice(first, rows);
    }
    std::sort(out_.ghost.begin(), out_.ghost.end());
    out_.ghost.erase(std::unique(out_.ghost.begin(), out_.ghost.end()), out_.ghost.end());
    return std::move(out_);
  }

 private:
  bool own(Index v) const { return v >= begin_ && v < end_; }

  void choose_elements() {
    for (Index t = 0; t < model_.cloth_triangle_count; ++t) {
      const Tri& tri = model_.triangles[static_cast<std::size_t>(t)];
      if (std::any_of(tri.v, tri.v + 3, [&](Index v) { return own(v); }))
        out_.triangles.push_back(t);
    }
    for (std::size_t h = 0; h < model_.hinges.size(); ++h) {
      const Hinge& hinge = model_.hinges[h];
      if (std::any_of(hinge.v, hinge.v + 4, [&](Index v) { return own(v); }))
        out_.hinges.push_back(static_cast<Index>(h));
    }
  }

  /// For each own row the corners of elements there: triangles first, each kind ascending.
  void list_corners() {
    const auto rows = static_cast<std::size_t>(end_ - begin_);
    std::vector<Offset>& offset = out_.corner_source_offset;
    offset.assign(rows + 1, 0);
    const auto visit = [&](auto&& use) {
      for (std::size_t n = 0; n < out_.triangles.size(); ++n)
        for (int i = 0; i < 3; ++i)
          use(model_.triangles[static_cast<std::size_t>(out_.triangles[n])].v[i],
              static_cast<Index>(3 * n) + i);
      for (std::size_t n = 0; n < out_.hinges.size(); ++n)
        for (int i = 0; i < 4; ++i)
          use(model_.hinges[static_cast<std::size_t>(out_.hinges[n])].v[i],
              -1 - (static_cast<Index>(4 * n) + i));
    };
    visit([&](Index v, Index) {
      if (own(v)) ++offset[static_cast<std::size_t>(v - begin_) + 1];
    });
    for (std::size_t r = 0; r < rows; ++r) offset[r + 1] += offset[r];
    std::vector<Offset> place(offset.begin(), offset.end() - 1);
    out_.corner_source.resize(static_cast<std::size_t>(offset[rows]));
    visit([&](Index v, Index source) {
      if (own(v))
        out_.corner_source[static_cast<std::size_t>(
            place[static_cast<std::size_t>(v - begin_)]++)] = source;
    });
  }

  /// Entries of one row by column, sources of an entry in their fixed order. Always has the
  /// diagonal.
  void collect_row(Index row, std::vector<Entry>& entries) const {
    entries.clear();
    if (row >= end_) return;
    const auto r = static_cast<std::size_t>(row - begin_);
    for (Offset s = out_.corner_source_offset[r]; s < out_.corner_source_offset[r + 1]; ++s) {
      const Index source = out_.corner_source[static_cast<std::size_t>(s)];
      if (source >= 0) {
        const Tri& t = model_.triangles[static_cast<std::size_t>(
            out_.triangles[static_cast<std::size_t>(source / 3)])];
        for (int j = 0; j < 3; ++j) entries.push_back({t.v[j], 3 * source + j});
      } else {
        const Index code = -1 - source;
        const Hinge& h =
            model_
                .hinges[static_cast<std::size_t>(out_.hinges[static_cast<std::size_t>(code / 4)])];
        for (int j = 0; j < 4; ++j) entries.push_back({h.v[j], -1 - (4 * code + j)});
      }
    }
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.column < b.column; });
  }

  void append_slice(Index first, const std::vector<std::vector<Entry>>& rows) {
    std::vector<std::size_t> cursor(rows.size(), 0);
    bool any = true;
    Offset slots = 0;
    while (true) {
      any = false;
      for (std::size_t lane = 0; lane < rows.size(); ++lane)
        any = any || cursor[lane] < rows[lane].size();
      if (!any) break;
      ++slots;
      for (std::size_t lane = 0; lane < rows.size(); ++lane) {
        const std::vector<Entry>& entries = rows[lane];
        // Lanes beyond the last row repeat it, so that their column is a valid vertex.
        Index column = std::min(first + static_cast<Index>(lane), end_ - 1);
        if (cursor[lane] < entries.size()) {
          column = entries[cursor[lane]].column;
          for (; cursor[lane] < entries.size() && entries[cursor[lane]].column == column;
               ++cursor[lane])
            out_.block_source.push_back(entries[cursor[lane]].source);
          if (!own(column)) out_.ghost.push_back(column);
        }
        out_.column.push_back(column);
        out_.block_source_offset.push_back(static_cast<Offset>(out_.block_source.size()));
      }
    }
    out_.slice_offset.push_back(out_.slice_offset.back() + slots);
  }

  const Model& model_;
  Index begin_;
  Index end_;
  MeshRows out_;
};

}  // namespace

MeshRows make_mesh_rows(const Model& model, const Partition& partition, int rank) {
  return MeshRowsBuilder(model, partition, rank).build();
}

}  // namespace weft
