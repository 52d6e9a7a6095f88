#include "host/implicit/linear/mesh_rows.hpp"

#include <algorithm>
#include <numeric>

#include "host/base/parallel.hpp"
#include "weft/core/at.hpp"

namespace weft {
namespace {

struct Entry {
  Index column;
  BlockSource source;
};

void sort_unique(std::vector<Index>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

class MeshRowsBuilder {
 public:
  MeshRowsBuilder(const Model& model, const Partition& partition, int rank)
      : model_(model),
        begin_(partition.row_begin[static_cast<std::size_t>(rank)]),
        end_(partition.row_begin[static_cast<std::size_t>(rank) + 1]),
        slice_(partition.slice),
        window_(slice_ == cuda_slice ? RowOrder::window : slice_) {}

  MeshRows build() {
    choose_elements();
    list_corners();
    const auto windows = at((end_ - begin_ + window_ - 1) / window_);
    const unsigned threads = setup_threads(at(end_ - begin_));
    std::vector<MeshRows> parts(threads);  // of neighbouring windows each
    on_threads(threads, [&](unsigned n) {
      begin_lists(parts[n]);
      std::vector<Row> rows(at(window_));
      for (std::size_t w = windows * n / threads; w < windows * (n + 1) / threads; ++w)
        append_window(begin_ + static_cast<Index>(w) * window_, rows, parts[n]);
    });
    begin_lists(out_);
    for (const MeshRows& part : parts) append(part);
    sort_unique(out_.ghost);
    return std::move(out_);
  }

 private:
  struct Row {
    Index vertex = 0;  ///< may be beyond the last one
    Index count = 0;   ///< of entries, which may have several sources each
    std::vector<Entry> sources;
  };

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

  /// Entries of one row by column but for its own, sources of an entry in their fixed order.
  void collect_row(Index row, Row& out) const {
    std::vector<Entry>& entries = out.sources;
    out.vertex = row;
    out.count = 0;
    entries.clear();
    if (row >= end_) return;
    const auto r = static_cast<std::size_t>(row - begin_);
    const auto add = [&](Index column, BlockSource source) {
      if (column != row) entries.push_back({column, source});
    };
    for (Offset s = out_.corner_source_offset[r]; s < out_.corner_source_offset[r + 1]; ++s) {
      const Index source = out_.corner_source[static_cast<std::size_t>(s)];
      if (source >= 0) {
        const Tri& t = model_.triangles[static_cast<std::size_t>(
            out_.triangles[static_cast<std::size_t>(source / 3)])];
        for (int j = 0; j < 3; ++j) add(t.v[j], 3 * source + j);
      } else {
        const Index code = -1 - source;
        const Hinge& h =
            model_
                .hinges[static_cast<std::size_t>(out_.hinges[static_cast<std::size_t>(code / 4)])];
        for (int j = 0; j < 4; ++j) add(h.v[j], -1 - (4 * code + j));
      }
    }
    // Stable, and quicker than a sort that is made for more than some dozens.
    for (std::size_t i = 1; i < entries.size(); ++i) {
      const Entry entry = entries[i];
      std::size_t place = i;
      for (; place > 0 && entries[place - 1].column > entry.column; --place)
        entries[place] = entries[place - 1];
      entries[place] = entry;
    }
    for (std::size_t i = 0; i < entries.size(); ++i)
      out.count += i == 0 || entries[i].column != entries[i - 1].column ? 1 : 0;
  }

  static void begin_lists(MeshRows& out) {
    out.slice_offset.push_back(0);
    out.block_source_offset.push_back(0);
  }

  /// Appends rows that follow those that are there.
  void append(const MeshRows& part) {
    const auto add = [](auto& all, const auto& more) {
      all.insert(all.end(), more.begin(), more.end());
    };
    const auto add_offsets = [](std::vector<Offset>& all, const std::vector<Offset>& more) {
      const Offset base = all.back();
      all.reserve(all.size() + more.size() - 1);
      for (std::size_t i = 1; i < more.size(); ++i) all.push_back(base + more[i]);
    };
    add(out_.order, part.order);
    add(out_.column, part.column);
    add(out_.block_source, part.block_source);
    add(out_.ghost, part.ghost);
    add_offsets(out_.slice_offset, part.slice_offset);
    add_offsets(out_.block_source_offset, part.block_source_offset);
  }

  /// @param rows [window] of any content
  void append_window(Index first, std::vector<Row>& rows, MeshRows& out) const {
    for (Index n = 0; n < window_; ++n) collect_row(first + n, rows[at(n)]);
    if (window_ == RowOrder::window) append_order(first, rows, out);
    for (Index n = 0; n < std::min(window_, end_ - first); n += slice_)
      append_slice(rows.data() + n, out);
  }

  /// Sorts the rows of a window, and notes their order.
  void append_order(Index first, std::vector<Row>& rows, MeshRows& out) const {
    const Index count = std::min(window_, end_ - first);
    std::stable_sort(rows.begin(), rows.begin() + count,
                     [](const Row& a, const Row& b) { return a.count > b.count; });
    std::vector<Index> place(static_cast<std::size_t>(count));
    for (Index p = 0; p < count; ++p)
      place[static_cast<std::size_t>(rows[static_cast<std::size_t>(p)].vertex - first)] = p;
    for (Index p = 0; p < count; ++p) {
      const Row& row = rows[static_cast<std::size_t>(p)];
      out.order.push_back(
          RowOrder::pack(row.vertex - first, place[static_cast<std::size_t>(p)], row.count));
    }
  }

  /// @param rows [slice]
  void append_slice(const Row* rows, MeshRows& out) const {
    const auto width = static_cast<std::size_t>(slice_);
    std::vector<std::size_t> cursor(width, 0);
    bool any = true;
    Offset slots = 0;
    while (true) {
      any = false;
      for (std::size_t lane = 0; lane < width; ++lane)
        any = any || cursor[lane] < rows[lane].sources.size();
      if (!any) break;
      ++slots;
      for (std::size_t lane = 0; lane < width; ++lane) {
        const std::vector<Entry>& entries = rows[lane].sources;
        // Lanes beyond the last row repeat it, so that their column is a valid vertex.
        Index column = std::min(rows[lane].vertex, end_ - 1);
        if (cursor[lane] < entries.size()) {
          column = entries[cursor[lane]].column;
          for (; cursor[lane] < entries.size() && entries[cursor[lane]].column == column;
               ++cursor[lane])
            out.block_source.push_back(entries[cursor[lane]].source);
          if (!own(column)) out.ghost.push_back(column);
        }
        out.column.push_back(column);
        out.block_source_offset.push_back(static_cast<Offset>(out.block_source.size()));
      }
    }
    out.slice_offset.push_back(out.slice_offset.back() + slots);
  }

  const Model& model_;
  Index begin_;
  Index end_;
  Index slice_;
  Index window_;  ///< rows that are sorted together
  MeshRows out_;
};

/// Rows are taken window by window, first to count entries and then to write them: threads have
/// windows of their own.
class PlateRowsBuilder {
 public:
  PlateRowsBuilder(const PlateMatrix& matrix, const MeshRows& mesh, const Partition& partition,
                   int rank)
      : matrix_(matrix),
        mesh_(mesh),
        begin_(partition.row_begin[static_cast<std::size_t>(rank)]),
        end_(partition.row_begin[static_cast<std::size_t>(rank) + 1]),
        slice_(partition.slice),
        order_{mesh.order},
        threads_(setup_threads(at(end_ - begin_))) {}

  PlateRows build() {
    count();
    const auto in = static_cast<std::size_t>(out_.in_pattern_offset.back());
    const auto off = static_cast<std::size_t>(out_.off_pattern_slice_offset.back()) * at(slice_);
    for_each_index(std::min(threads_, 2U), 2, [&](std::size_t n) {
      if (n == 0) {
        out_.in_pattern_place.resize(in);
        out_.in_pattern_column.resize(in);
        out_.in_pattern_stiffness.resize(in);
        out_.in_pattern_damping.resize(in);
      } else {
        out_.off_pattern_column.resize(off);
        out_.off_pattern_stiffness.resize(off);
        out_.off_pattern_damping.resize(off);
      }
    });
    for_each_window([&](Index first, Far& far) {
      for (Index n = 0; n < std::min(RowOrder::window, end_ - first); ++n)
        write_row(first + n, far);
      for (Index n = 0; n < std::min(RowOrder::window, end_ - first); n += slice_)
        write_slice(first, n, far);
    });
    out_.ghost = mesh_.ghost;
    for (auto e = static_cast<std::size_t>(matrix_.row_offset[at(begin_)]);
         e < static_cast<std::size_t>(matrix_.row_offset[at(end_)]); ++e)
      if (matrix_.column[e] < begin_ || matrix_.column[e] >= end_)
        out_.ghost.push_back(matrix_.column[e]);
    sort_unique(out_.ghost);
    return std::move(out_);
  }

 private:
  /// For each row of a window its entries off the pattern.
  using Far = std::vector<std::vector<std::size_t>>;

  /// Calls use(first row, room for its rows' entries) for each window, on several threads.
  template <class Use>
  void for_each_window(const Use& use) const {
    const auto windows = at((end_ - begin_ + RowOrder::window - 1) / RowOrder::window);
    on_threads(threads_, [&](unsigned thread) {
      Far far(RowOrder::window);
      for (std::size_t w = windows * thread / threads_; w < windows * (thread + 1) / threads_;
           ++w) {
        for (std::vector<std::size_t>& row : far) row.clear();
        use(begin_ + static_cast<Index>(w) * RowOrder::window, far);
      }
    });
  }

  /// Sets the offsets.
  void count() {
    const Index rows = end_ - begin_;
    out_.in_pattern_offset.assign(at(rows) + 1, 0);
    out_.off_pattern_slice_offset.assign(at((rows + slice_ - 1) / slice_) + 1, 0);
    for_each_window([&](Index first, Far& far) {
      for (Index n = 0; n < std::min(RowOrder::window, end_ - first); ++n)
        split_row(
            first + n, [&](std::size_t e) { far[at(n)].push_back(e); },
            [&](std::size_t, Offset) { ++out_.in_pattern_offset[at(first - begin_ + n) + 1]; });
      for (Index n = 0; n < std::min(RowOrder::window, end_ - first); n += slice_) {
        Offset& longest = out_.off_pattern_slice_offset[at((first - begin_ + n) / slice_) + 1];
        for (Index place = n; place < n + slice_; ++place)
          longest = std::max(longest, static_cast<Offset>(far[at(row_of(first, place))].size()));
      }
    });
    for (std::vector<Offset>* offset : {&out_.in_pattern_offset, &out_.off_pattern_slice_offset})
      std::partial_sum(offset->begin(), offset->end(), offset->begin());
  }

  /// Row at a place of a window, both counted from its first; where there is none: the place.
  Index row_of(Index first, Index place) const {
    return first + place < end_ ? order_.row(first - begin_ + place) % RowOrder::window : place;
  }

  /// Calls far(entry) or near(entry, its place among the values of the mesh) for each entry of a
  /// row but its own, which is minus the sum of the others.
  template <class IsFar, class IsNear>
  void split_row(Index row, const IsFar& far, const IsNear& near) const {
    const auto r = static_cast<std::size_t>(row);
    const Index place = order_.place(row - begin_);
    const auto slice = static_cast<std::size_t>(place / slice_);
    const Index lane = place % slice_;
    // Columns ascend on both sides; padding repeats the row's own column, behind the real ones.
    Offset slot = mesh_.slice_offset[slice];
    const auto entry = [&] { return static_cast<std::size_t>(slot * slice_ + lane); };
    const auto is_real = [&] {
      return slot < mesh_.slice_offset[slice + 1] &&
             mesh_.block_source_offset[entry()] < mesh_.block_source_offset[entry() + 1];
    };
    for (auto e = static_cast<std::size_t>(matrix_.row_offset[r]);
         e < static_cast<std::size_t>(matrix_.row_offset[r + 1]); ++e) {
      if (matrix_.column[e] == row) continue;
      while (is_real() && mesh_.column[entry()] < matrix_.column[e]) ++slot;
      if (!is_real() || mesh_.column[entry()] != matrix_.column[e])
        far(e);
      else
        near(e, slot * 9 * slice_ + lane);
    }
  }

  void write_row(Index row, Far& far) {
    auto next = static_cast<std::size_t>(out_.in_pattern_offset[at(row - begin_)]);
    split_row(
        row, [&](std::size_t e) { far[at((row - begin_) % RowOrder::window)].push_back(e); },
        [&](std::size_t e, Offset place) {
          out_.in_pattern_place[next] = place;
          out_.in_pattern_column[next] = matrix_.column[e];
          out_.in_pattern_stiffness[next] = matrix_.stiffness[e];
          out_.in_pattern_damping[next++] = matrix_.damping[e];
        });
  }

  /// @param far of the window that begins with vertex `first`   @param begin first place there
  void write_slice(Index first, Index begin, const Far& far) {
    const auto slice = at((first - begin_ + begin) / slice_);
    const Offset* offset = out_.off_pattern_slice_offset.data() + slice;
    auto next = static_cast<std::size_t>(offset[0]) * at(slice_);
    for (std::size_t n = 0; n < static_cast<std::size_t>(offset[1] - offset[0]); ++n)
      for (Index place = begin; place < begin + slice_; ++place, ++next) {
        const Index own = row_of(first, place);
        const std::vector<std::size_t>& row = far[at(own)];
        const bool real = n < row.size();
        out_.off_pattern_column[next] =
            real ? matrix_.column[row[n]] : std::min(first + own, end_ - 1);
        out_.off_pattern_stiffness[next] = real ? matrix_.stiffness[row[n]] : 0;
        out_.off_pattern_damping[next] = real ? matrix_.damping[row[n]] : 0;
      }
  }

  const PlateMatrix& matrix_;
  const MeshRows& mesh_;
  Index begin_;
  Index end_;
  Index slice_;
  RowOrder order_;
  unsigned threads_;
  PlateRows out_;
};

}  // namespace

PlateRows make_plate_rows(const PlateMatrix& matrix, const MeshRows& mesh,
                          const Partition& partition, int rank) {
  if (matrix.row_offset.empty()) {
    PlateRows none;
    none.ghost = mesh.ghost;
    return none;
  }
  return PlateRowsBuilder(matrix, mesh, partition, rank).build();
}

MeshRows make_mesh_rows(const Model& model, const Partition& partition, int rank) {
  return MeshRowsBuilder(model, partition, rank).build();
}

std::vector<double> slots_of_rows(const std::vector<Offset>& slice_offset, const RowOrder& order,
                                  Index slice, std::size_t rows) {
  std::vector<double> slots;
  slots.reserve(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    const auto s = static_cast<std::size_t>(order.place(static_cast<Index>(i)) / slice);
    slots.push_back(static_cast<double>(slice_offset[s + 1] - slice_offset[s]));
  }
  return slots;
}

}  // namespace weft
