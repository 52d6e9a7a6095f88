// P-Cloth's matrix assembly (Li et al. 2020, section 3.2.2) against the engine's: five steps that
// find the pattern again and sum values with floating-point atomics, which no two runs need agree
// on to the bit, so that it is a benchmark and not in the library. Same system: membrane, hinges,
// masses and, folded, contacts.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "benchmarks/support/elements.hpp"
#include "benchmarks/support/kernel_bench.hpp"
#include "benchmarks/support/queue_clock.hpp"

namespace weft::bench {
namespace {

/// The tables of a block-ELL matrix as the paper has them: rows stand next to each other, entry
/// `slot` of row r at slot * rows + r, component k of its block at (9 slot + k) * rows + r.
template <class T>
struct Filling {
  SystemArgs<T> system;
  Span<Index> length;  ///< [rows] indices listed, then those that differ
  Span<Index> cursor;  ///< [rows] indices filled in
  Span<Index> most;    ///< [2] longest row: as listed, compacted
  Span<Index> index;   ///< [longest row as listed][rows] Index Table
  Span<T> value;       ///< [longest row compacted][9][rows] Value Table
  Span<Vec3<T>> rhs;   ///< [rows]

  WEFT_HD std::size_t rows() const noexcept { return length.size(); }
};

/// Step 1, for each element: room that it needs in the rows of its corners.
template <ElementKind kind>
struct CountIndices {
  template <class T>
  WEFT_HD void operator()(const Filling<T>& a, Index n) const noexcept {
    const Corners e = Elements<T>(a.system).template corners<kind>(n);
    for (int i = 0; i < 4; ++i)
      if (e.v[i] >= 0) add_to(a.length.data()[e.v[i]], e.count());
  }
};

/// Steps 1 and 3, for each row: the longest.
template <int which>
struct FindMost {
  template <class T>
  WEFT_HD void operator()(const Filling<T>& a, Index row) const noexcept {
    raise_to(a.most.data()[which], a.length.data()[row]);
  }
};

/// Step 2, for each element: its columns into the rows of its corners.
template <ElementKind kind>
struct FillIndices {
  template <class T>
  WEFT_HD void operator()(const Filling<T>& a, Index n) const noexcept {
    const Corners e = Elements<T>(a.system).template corners<kind>(n);
    for (int i = 0; i < 4; ++i) {
      if (e.v[i] < 0) continue;
      auto slot = static_cast<std::size_t>(add_to(a.cursor.data()[e.v[i]], e.count()));
      for (int j = 0; j < 4; ++j)
        if (e.v[j] >= 0)
          a.index.data()[slot++ * a.rows() + static_cast<std::size_t>(e.v[i])] = e.v[j];
    }
  }
};

/// First of a row's `count` sorted columns that is not below `column`.
template <class T>
WEFT_HD Index find_slot(const Filling<T>& a, Index row, Index count, Index column) noexcept {
  Index low = 0;
  Index high = count;
  while (low < high) {
    const Index middle = low + (high - low) / 2;
    const auto at = static_cast<std::size_t>(middle) * a.rows() + static_cast<std::size_t>(row);
    if (a.index.data()[at] < column)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/// Step 3, for each row: its columns ascending, each once. What is sorted takes no more room than
/// what has been read.
struct CompactRow {
  template <class T>
  WEFT_HD void operator()(const Filling<T>& a, Index row) const noexcept {
    Index* const first = a.index.data() + row;
    const std::size_t stride = a.rows();
    const Index listed = a.length.data()[row];
    Index count = 0;
    for (Index slot = 0; slot < listed; ++slot) {
      const Index column = first[static_cast<std::size_t>(slot) * stride];
      const Index place = find_slot(a, row, count, column);
      if (place < count && first[static_cast<std::size_t>(place) * stride] == column) continue;
      for (Index k = count; k > place; --k)
        first[static_cast<std::size_t>(k) * stride] =
            first[static_cast<std::size_t>(k - 1) * stride];
      first[static_cast<std::size_t>(place) * stride] = column;
      ++count;
    }
    a.length.data()[row] = count;
  }
};

/// Step 5, for each element: what it adds to the entries of its corners, and to the right-hand
/// side.
template <ElementKind kind>
struct FillValues {
  template <class T>
  WEFT_HD void operator()(const Filling<T>& a, Index n) const noexcept {
    const Elements<T> elements(a.system);
    const Corners e = elements.template corners<kind>(n);
    elements.template visit<kind>(
        n,
        [&](int i, int j, const Mat3<T>& block) {
          if (e.v[i] < 0 || e.v[j] < 0) return;
          const Index slot = find_slot(a, e.v[i], a.length.data()[e.v[i]], e.v[j]);
          T* value = a.value.data() + 9 * static_cast<std::size_t>(slot) * a.rows() +
                     static_cast<std::size_t>(e.v[i]);
          for (int k = 0; k < 9; ++k, value += a.rows()) add_to(*value, block.e[k]);
        },
        [&](int i, const Vec3<T>& impulse) {
          if (e.v[i] < 0) return;
          for (int c = 0; c < 3; ++c) add_to(a.rhs.data()[e.v[i]][c], impulse[c]);
        });
  }
};

/// The five steps, as often as one likes; memory only grows.
template <class T>
class FiveSteps {
 public:
  FiveSteps(Device& device, const SystemArgs<T>& system)
      : queue_(device.compute()),
        rows_(static_cast<std::size_t>(system.rows.matrix.row_count)),
        length_(device, rows_),
        cursor_(device, rows_),
        most_(device, 2),
        index_(device),
        value_(device),
        rhs_(device, rows_) {
    args_.system = system;
    args_.length = length_.span();
    args_.cursor = cursor_.span();
    args_.most = most_.span();
    args_.rhs = rhs_.span();
  }

  /// Waits for the queue twice, for the sizes of the tables.
  void assemble() {
    allocate_indices();
    fill_indices();
    compact();
    allocate_values();
    fill_values();
  }
  void allocate_indices() {
    queue_.fill(length_.data(), 0, rows_ * sizeof(Index));
    queue_.fill(most_.data(), 0, 2 * sizeof(Index));
    for_each_element<CountIndices>(queue_, args_);
    for_each(queue_, args_, row_count(), FindMost<0>{});
    listed_width_ = read_most(0);
    index_.resize(static_cast<std::size_t>(listed_width_) * rows_);
    args_.index = index_.span();
  }
  void fill_indices() {
    queue_.fill(cursor_.data(), 0, rows_ * sizeof(Index));
    for_each_element<FillIndices>(queue_, args_);
  }
  void compact() {
    for_each(queue_, args_, row_count(), CompactRow{});
    for_each(queue_, args_, row_count(), FindMost<1>{});
  }
  void allocate_values() {
    width_ = read_most(1);
    value_.resize(static_cast<std::size_t>(width_) * 9 * rows_);
    args_.value = value_.span();
    queue_.fill(value_.data(), 0, value_.size() * sizeof(T));
    queue_.fill(rhs_.data(), 0, rows_ * sizeof(Vec3<T>));
  }
  void fill_values() { for_each_element<FillValues>(queue_, args_); }

  Index listed_width() const { return listed_width_; }
  Index width() const { return width_; }
  std::vector<Index> lengths() { return download(queue_, length_); }
  std::vector<Index> indices() { return download(queue_, index_); }
  std::vector<T> values() { return download(queue_, value_); }
  std::vector<Vec3<T>> rhs() { return download(queue_, rhs_); }
  std::size_t bytes() const { return index_.size() * sizeof(Index) + value_.size() * sizeof(T); }

 private:
  Index row_count() const { return static_cast<Index>(rows_); }
  Index read_most(std::size_t which) {
    Index most = 0;
    queue_.copy(&most, most_.data() + which, sizeof most);
    queue_.sync();
    return most;
  }

  Queue& queue_;
  std::size_t rows_;
  Buffer<Index> length_, cursor_, most_, index_;
  Buffer<T> value_;
  Buffer<Vec3<T>> rhs_;
  Filling<T> args_{};
  Index listed_width_ = 0, width_ = 0;
};

template <class V>
std::vector<V> fetch(Queue& queue, const V* from, std::size_t count) {
  std::vector<V> to(count);
  queue.copy(to.data(), from, count * sizeof(V));
  queue.sync();
  return to;
}

/// Blocks of a row; padding, which is zero, included.
using RowBlocks = std::vector<std::pair<Index, Mat3<double>>>;

Mat3<double>& block_of(RowBlocks& blocks, Index column) {
  auto at = std::find_if(blocks.begin(), blocks.end(),
                         [column](const auto& block) { return block.first == column; });
  if (at == blocks.end()) at = blocks.insert(at, {column, Mat3<double>{}});
  return at->second;
}

/// A matrix of the engine's in the host's memory.
template <class T>
struct HostMatrix {
  HostMatrix(Queue& queue, const BlockEll<T>& m) : slice(static_cast<std::size_t>(m.slice)) {
    if (m.row_count == 0) return;
    const auto slices = static_cast<std::size_t>((m.row_count + m.slice - 1) / m.slice);
    offset = fetch(queue, m.slice_offset.data(), slices + 1);
    const auto entries = static_cast<std::size_t>(offset.back()) * slice;
    column = fetch(queue, m.column.data(), entries);
    value = fetch(queue, m.value.data(), 9 * entries);
    diagonal = fetch(queue, m.diagonal.data(), m.diagonal.size());
  }

  void add_row(std::size_t row, RowBlocks& blocks) const {
    if (offset.empty()) return;
    if (!diagonal.empty())
      for (std::size_t k = 0; k < 9; ++k)
        block_of(blocks, static_cast<Index>(row)).e[k] += static_cast<double>(diagonal[row].e[k]);
    for (auto slot = static_cast<std::size_t>(offset[row / slice]);
         slot < static_cast<std::size_t>(offset[row / slice + 1]); ++slot) {
      Mat3<double>& block = block_of(blocks, column[slot * slice + row % slice]);
      for (std::size_t k = 0; k < 9; ++k)
        block.e[k] += static_cast<double>(value[(slot * 9 + k) * slice + row % slice]);
    }
  }

  std::size_t slice;
  std::vector<Offset> offset;
  std::vector<Index> column;
  std::vector<T> value;
  std::vector<Mat3<T>> diagonal;
};

/// Links of the engine's in the host's memory.
template <class T>
struct HostContactOperator {
  HostContactOperator(Queue& queue, const AssembleContacts<T>& c) {
    if (c.contact_entry_count.empty()) return;
    offset = fetch(queue, c.row_entry_count.data(), static_cast<std::size_t>(c.row_count) + 1);
    end = fetch(queue, c.contact_scatter.data(), static_cast<std::size_t>(offset.back()));
    count = fetch(queue, c.contact_entry_count.data(), 1);
    link = fetch(queue, c.link.data(), static_cast<std::size_t>(count.front()));
    links = {link, count, offset, end, {}};
  }
  HostContactOperator(const HostContactOperator&) = delete;

  void add_row(std::size_t row, RowBlocks& blocks) const {
    visit_contact_entries(links, static_cast<Index>(row),
                          [&](Index column, T weight, const ContactOperatorEntry<T>& from) {
                            Mat3<double>& block = block_of(blocks, column);
                            for (int k = 0; k < 9; ++k)
                              block.e[k] += static_cast<double>(weight * from.component(k));
                          });
  }

  std::vector<Index> offset, count;
  std::vector<ContactScatter<T>> end;
  std::vector<ContactOperatorEntry<T>> link;
  ContactOperator<T> links;
};

/// How far two assemblies are from each other.
struct Difference {
  double value = 0;          ///< largest of components over the largest component
  double rhs = 0;            ///< of the right-hand side, as above
  std::int64_t missing = 0;  ///< blocks that are not zero on one side and not there on the other
};

template <class T>
Difference compare(Queue& queue, const SystemArgs<T>& system, FiveSteps<T>& steps) {
  const auto rows = static_cast<std::size_t>(system.rows.matrix.row_count);
  const BlockEllOut<T>& m = system.rows.matrix;
  const AssembleContacts<T>& c = system.contacts;
  const HostMatrix<T> mesh(queue,
                           {m.row_count, m.slice, m.slice_offset, m.column, m.value, m.diagonal});
  const HostContactOperator<T> links(queue, c);
  const std::vector<Index> length = steps.lengths(), index = steps.indices();
  const std::vector<T> value = steps.values();
  Difference d;
  double most = 0, most_rhs = 0;
  RowBlocks blocks;
  for (std::size_t row = 0; row < rows; ++row) {
    blocks.clear();
    mesh.add_row(row, blocks);
    links.add_row(row, blocks);
    std::size_t met = 0;
    for (const auto& [column, block] : blocks) {
      Index slot = 0;
      while (slot < length[row] && index[static_cast<std::size_t>(slot) * rows + row] != column)
        ++slot;
      const bool there = slot < length[row];
      met += there ? 1 : 0;
      for (std::size_t k = 0; k < 9; ++k) {
        most = std::max(most, std::abs(block.e[k]));
        if (!there && block.e[k] != 0) ++d.missing;
        if (there)
          d.value = std::max(
              d.value,
              std::abs(block.e[k] -
                       double(value[(9 * static_cast<std::size_t>(slot) + k) * rows + row])));
      }
    }
    d.missing += length[row] - static_cast<std::int64_t>(met);
  }
  const auto right = fetch(queue, c.row_count == 0 ? system.rows.rhs.data() : c.rhs.data(), rows);
  const std::vector<Vec3<T>> filled = steps.rhs();
  for (std::size_t row = 0; row < rows; ++row)
    for (int k = 0; k < 3; ++k) {
      most_rhs = std::max(most_rhs, std::abs(double(right[row][k])));
      d.rhs = std::max(d.rhs, std::abs(double(right[row][k]) - double(filled[row][k])));
    }
  d.value /= most;
  d.rhs /= most_rhs;
  return d;
}

/// Entries whose bits two fillings do not agree on.
template <class T>
std::int64_t restless(FiveSteps<T>& steps) {
  const std::vector<T> before = steps.values();
  steps.assemble();
  const std::vector<T> after = steps.values();
  std::int64_t count = 0;
  for (std::size_t k = 0; k < before.size(); ++k) count += before[k] != after[k] ? 1 : 0;
  return count;
}

template <class T>
Json measure_steps(Queue& queue, FiveSteps<T>& steps, int repeats) {
  Json us;
  const auto book = [&](const char* name, void (FiveSteps<T>::*step)()) {
    us.add(name, 1e6 * median_time(queue, repeats, [&] { (steps.*step)(); }));
  };
  book("index_table_allocating", &FiveSteps<T>::allocate_indices);
  book("index_filling", &FiveSteps<T>::fill_indices);
  // What is compacted has to be filled in again.
  QueueClock clock;
  std::vector<double> times;
  for (int repeat = 0; repeat <= repeats; ++repeat) {
    steps.allocate_indices();
    steps.fill_indices();
    clock.start(queue);
    steps.compact();
    times.push_back(clock.stop(queue));
  }
  std::sort(times.begin(), times.end());
  us.add("index_compacting", 1e6 * times[times.size() / 2]);
  book("value_table_allocating", &FiveSteps<T>::allocate_values);
  book("value_filling", &FiveSteps<T>::fill_values);
  return us;
}

/// @throws std::runtime_error if the two do not have the same values up to rounding
template <class T>
Json measure(const Options& options, int vertices, bool folded) {
  const auto cells = static_cast<Index>(std::lround(std::sqrt(double(vertices)))) - 1;
  Scene scene = wavy_sheet(cells);
  scene.bending = Bending::hinge;
  FirstSystem<T> first(scene, parse_devices(options.device), folded);
  const SystemArgs<T> system = assemble_and_catch(first);
  Device& device = first.device();
  Queue& queue = device.compute();
  FiveSteps<T> steps(device, system);
  const int repeats = options.smoke ? 1 : 10;
  const double engine = median_time(queue, repeats, [&] { assemble_again(queue, system); });
  const double whole = median_time(queue, repeats, [&] { steps.assemble(); });
  const Difference difference = compare(queue, system, steps);
  Json result;
  result.add("vertices", system.rows.matrix.row_count);
  result.add("triangles", static_cast<double>(system.membrane.triangles.size()));
  result.add("hinges", static_cast<double>(system.bending.hinges.size()));
  result.add("contacts", static_cast<double>(system.contacts.contacts.size()));
  result.add("precision", sizeof(T) == 4 ? "float" : "double");
  result.add("engine_us", 1e6 * engine).add("five_steps_us", 1e6 * whole);
  result.add("longest_row_listed", steps.listed_width()).add("longest_row", steps.width());
  result.add("table_bytes", static_cast<double>(steps.bytes()));
  result.add("difference", difference.value).add("difference_rhs", difference.rhs);
  result.add("missing", static_cast<double>(difference.missing));
  result.add("values_that_change_from_run_to_run", static_cast<double>(restless(steps)));
  result.add("steps_us", measure_steps(queue, steps, repeats));
  std::cout << result.text() << std::endl;
  // A sum of some dozens of terms, each of them rounded in another order; impulses come from
  // strains of a percent, a hundred times as large a share of which is rounding.
  const double bound = 64 * (sizeof(T) == sizeof(float) ? 0x1p-23 : 0x1p-52);
  if (difference.missing != 0 || !(difference.value < bound) || !(difference.rhs < 100 * bound))
    throw std::runtime_error("the five steps and the engine do not assemble the same system");
  return result;
}

void measure_all(const Options& options) {
  Json results('[');
  for (const int vertices : options.vertices)
    for (const bool folded : {false, true}) {
      results.add(measure<float>(options, vertices, folded));
      if (options.smoke) results.add(measure<double>(options, vertices, folded));
    }
  write(options, "filling", results);
}

}  // namespace
}  // namespace weft::bench

int main(int argc, char** argv) {
  return weft::bench::run(argc, argv, weft::bench::measure_all);
}
