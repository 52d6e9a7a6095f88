#pragma once

#include <cmath>
#include <vector>

#include "host/implicit/contact/swept_mesh.hpp"
#include "tests/parity/support.hpp"
#include "weft/kernels/collide/boxes.hpp"
#include "weft/kernels/collide/grid.hpp"
#include "weft/shapes.hpp"

namespace weft::parity {

/// Obstacle after cloth: vertices, faces and edges.
inline SweptMesh joined(const SweptMesh& cloth, const SweptMesh& obstacle) {
  SweptMesh both = cloth;
  const Index first = cloth.counts.vertices;
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(both.positions_t0, obstacle.positions_t0);
  append(both.positions_t1, obstacle.positions_t1);
  for (const Tri& t : obstacle.triangles)
    both.triangles.push_back({{first + t.v[0], first + t.v[1], first + t.v[2]}});
  for (const Edge& e : obstacle.edges) both.edges.push_back({{first + e.v[0], first + e.v[1]}});
  both.counts.vertices += obstacle.counts.vertices;
  both.counts.triangles += obstacle.counts.triangles;
  both.counts.edges += obstacle.counts.edges;
  return both;
}

/// A grid of cells x cells quads, as `shape` bends it, moved by up to `motion` along each axis.
template <class Shape>
SweptMesh sheet(Random& random, int cells, double edge, double motion, Shape shape) {
  const Mesh grid = make_grid({edge * cells, edge * cells}, {cells, cells}, Diagonals::alternating);
  std::vector<Vec3<double>> from, to;
  for (const auto& p : grid.positions) {
    const Vec3<double> x = shape(p[0], p[1]);
    from.push_back(vec_cast<double>(vec_cast<float>(x)));
    to.push_back(vec_cast<double>(vec_cast<float>(x + random.vector<double>(-motion, motion))));
  }
  return make_swept_mesh(from, to, grid.triangles);
}

/// Cloth in folds, most of it in a heap, above a bump and a floor of two triangles that rest.
/// @param cells along each side of the cloth
inline SweptMesh folded_scene(int cells) {
  Random random(31);
  const double edge = 1.0 / cells;
  const SweptMesh cloth = sheet(random, cells, edge, 0.1 * edge, [&](double x, double y) {
    const Vec3<double> noise = random.vector<double>(-0.3 * edge, 0.3 * edge);
    if (x < 0.4 * y) return Vec3<double>{x, y, 0.02 * std::sin(20 * x)} + noise;
    return Vec3<double>{0.1 * std::sin(20 * x), 0.1 * std::cos(17 * y), 0.05 * (x + y)} + noise;
  });
  const SweptMesh bump = sheet(random, 9, 0.05, 0, [](double x, double y) {
    return Vec3<double>{x - 0.2, y - 0.2, 0.1 - x * x - y * y};
  });
  const SweptMesh floor = sheet(random, 1, 40.0, 0, [](double x, double y) {
    return Vec3<double>{x - 20, y - 20, 0.01};
  });
  return joined(joined(cloth, bump), floor);
}

/// Everything that CollideBoxes reads and writes, on one device.
template <class T>
class BoxBuffers {
 public:
  CollideBoxes<T> args{};

  BoxBuffers(Device& device, const SweptMesh& mesh) : device_(device), counts_(mesh.counts) {
    move(mesh.positions_t0, mesh.positions_t1);
    edges_ = upload(device, mesh.edges);
    triangles_ = upload(device, mesh.triangles);
    Random random(32);
    const auto cloth = static_cast<std::size_t>(mesh.counts.cloth_vertices);
    velocities_ = upload(device, random.vectors<T>(cloth, -1, 1));
    previous_velocities_ = upload(device, random.vectors<T>(cloth, -1, 1));
    swept_aabb_ = Buffer<BoxOf<T>>(device, static_cast<std::size_t>(mesh.counts.vertices));
    mean_extent_ = Buffer<float>(device, cluster_kinds);
    for (auto* flag : {&split_, &made_, &moved_}) *flag = Buffer<unsigned char>(device, 1);
    args.velocities = velocities_.span();
    args.previous_velocities = previous_velocities_.span();
    args.edges = edges_.span();
    args.triangles = triangles_.span();
    args.cloth_vertex_count = mesh.counts.cloth_vertices;
    args.swept_aabb = swept_aabb_.span();
    args.mean_extent = mean_extent_.span();
    args.split = split_.span();
    args.obstacles_made = made_.span();
    args.obstacles_moved = moved_.span();
    make_lists();
  }

  void move(const std::vector<Vec3<double>>& from, const std::vector<Vec3<double>>& to) {
    positions_t0_ = upload(device_, cast(from));
    positions_t1_ = upload(device_, cast(to));
    args.positions_t0 = positions_t0_.span();
    args.positions_t1 = positions_t1_.span();
  }

  void run() { launch(device_.compute(), args); }

  std::vector<BoxOf<T>> swept_aabb() const { return download(swept_aabb_); }
  std::vector<Cluster<T>> clusters(int kind) const { return download(clusters_[kind]); }
  std::vector<Cluster<float>> groups(int kind) const { return download(groups_[kind]); }
  std::vector<Box> hulls(int kind) const { return download(hulls_[kind]); }
  std::vector<float> mean_extent() const { return download(mean_extent_); }
  /// Those at the end of a motion that was split, and of obstacles.
  std::vector<Cluster<T>> ends(int kind) const { return download(ends_[kind]); }
  std::vector<Cluster<float>> group_ends(int kind) const { return download(group_ends_[kind]); }
  bool made() const { return download(made_).front() != 0; }
  bool moved() const { return download(moved_).front() != 0; }
  bool split() const { return download(split_).front() != 0; }

  /// Everything but mean_extent, which may differ between backends.
  Outputs outputs() const {
    Outputs all{{"swept AABB", numbers(swept_aabb())},
                {"made", {made() ? 1.0 : 0.0}},
                {"moved", {moved() ? 1.0 : 0.0}},
                {"split", {split() ? 1.0 : 0.0}}};
    for (int kind = 0; kind < cluster_kinds; ++kind) {
      const std::string of = " of kind " + std::to_string(kind);
      all.push_back({"clusters" + of, numbers(clusters(kind))});
      all.push_back({"groups" + of, numbers(groups(kind))});
      all.push_back({"hulls" + of, numbers(hulls(kind))});
      if (kind % 2 == cloth_vertices && !split()) continue;
      all.push_back({"ends" + of, numbers(ends(kind))});
      all.push_back({"ends of groups" + of, numbers(group_ends(kind))});
    }
    return all;
  }

 private:
  static std::vector<Vec3<T>> cast(const std::vector<Vec3<double>>& all) {
    std::vector<Vec3<T>> result;
    for (const auto& v : all) result.push_back(vec_cast<T>(v));
    return result;
  }
  template <class Bounds>
  static void append_bounds(std::vector<double>& all, const Bounds& b) {
    for (const auto* bound : {&b.lo, &b.hi})
      for (const auto& along : *bound) append_bound(all, along);
  }
  template <class S>
  static void append_bound(std::vector<double>& all, S x) {
    all.push_back(static_cast<double>(x));
  }
  template <class S, std::size_t N>
  static void append_bound(std::vector<double>& all, const S (&lanes)[N]) {
    for (const S x : lanes) all.push_back(static_cast<double>(x));
  }
  template <class Bounds>
  static std::vector<double> numbers(const std::vector<Bounds>& all) {
    std::vector<double> result;
    for (const Bounds& b : all) append_bounds(result, b);
    return result;
  }
  void make_lists() {
    const Index bounds[3][3] = {{0, counts_.cloth_vertices, counts_.vertices},
                                {0, counts_.cloth_triangles, counts_.triangles},
                                {0, counts_.cloth_edges, counts_.edges}};
    for (int kind = 0; kind < cluster_kinds; ++kind) {
      ClusterList<T>& list = args.lists[kind];
      list.first = bounds[kind / 2][kind % 2];
      list.count = bounds[kind / 2][kind % 2 + 1] - list.first;
      const auto size = static_cast<std::size_t>(list.size());
      const auto groups = static_cast<std::size_t>(list.group_count());
      for (auto* clusters : {&clusters_[kind], &ends_[kind]})
        *clusters = Buffer<Cluster<T>>(device_, size);
      for (auto* around : {&groups_[kind], &group_ends_[kind]})
        *around = Buffer<Cluster<float>>(device_, groups);
      hulls_[kind] = Buffer<Box>(device_, groups);
      list.clusters = clusters_[kind].span();
      list.groups = groups_[kind].span();
      list.hulls = hulls_[kind].span();
      list.ends = ends_[kind].span();
      list.group_ends = group_ends_[kind].span();
    }
  }

  Device& device_;
  PrimitiveCounts counts_;
  Buffer<Vec3<T>> positions_t0_, positions_t1_, velocities_, previous_velocities_;
  Buffer<Edge> edges_;
  Buffer<Tri> triangles_;
  Buffer<BoxOf<T>> swept_aabb_;
  Buffer<float> mean_extent_;
  Buffer<unsigned char> split_, made_, moved_;
  Buffer<Cluster<T>> clusters_[cluster_kinds], ends_[cluster_kinds];
  Buffer<Cluster<float>> groups_[cluster_kinds], group_ends_[cluster_kinds];
  Buffer<Box> hulls_[cluster_kinds];
};

/// A spatial hash on one device.
struct GridBuffers {
  Buffer<Box> boxes;
  Buffer<float> mean_extent;
  Buffer<unsigned char> wanted;
  Buffer<GridEntry> entries;
  Buffer<Index> bucket_offset;
  Buffer<std::uint32_t> levels;
  Buffer<float> cell;

  GridBuffers(Device& device, const std::vector<Box>& all, const std::vector<float>& extents,
              std::size_t buckets)
      : boxes(upload(device, all)),
        mean_extent(upload(device, extents)),
        wanted(upload(device, std::vector<unsigned char>{1})),
        entries(device, cells_a_box * all.size()),
        bucket_offset(device, buckets + 1),
        levels(device, 1),
        cell(device, 1) {}

  void run() {
    launch(cell.device().compute(),
           CollideGrid{boxes.span(), mean_extent.span().subspan(0, 1),
                       mean_extent.span().subspan(1, 1), wanted.span(), entries.span(),
                       bucket_offset.span(), levels.span(), cell.span()});
  }
  Grid view() const { return {entries.span(), bucket_offset.span(), levels.span(), cell.span()}; }

  Outputs outputs() const {
    const std::vector<Index> offsets = download(bucket_offset);
    std::vector<double> tags, numbers;
    const std::vector<GridEntry> all = download(entries);
    for (std::size_t e = 0; e < static_cast<std::size_t>(offsets.back()); ++e) {
      tags.push_back(all[e].tag);
      numbers.push_back(all[e].number);
    }
    return {output("offset", offsets),
            {"tag", tags},
            {"number", numbers},
            output("levels", download(levels)),
            output("cell", download(cell))};
  }
};

}  // namespace weft::parity
