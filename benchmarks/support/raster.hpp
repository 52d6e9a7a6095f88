#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "host/view/view_camera.hpp"
#include "weft/scene.hpp"

namespace weft::bench {

/// What a camera sees of the cloths, pixel by pixel.
struct Raster {
  int width = 0, height = 0;
  std::vector<float> depth;         ///< [m] along the view; infinity: nothing
  std::vector<unsigned char> part;  ///< 0 nothing, 1 cloth, 2 obstacle
  std::vector<float> shade;         ///< of cloth, |cosine| between its normal and the view

  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

/// [vertices] sums of the normals around, by area, not unit
inline std::vector<Vec3<double>> summed_normals(const Mesh& mesh) {
  std::vector<Vec3<double>> normals(mesh.positions.size(), Vec3<double>{0, 0, 0});
  const auto at = [&](Index v) -> const Vec3<double>& {
    return mesh.positions[static_cast<std::size_t>(v)];
  };
  for (const Tri& t : mesh.triangles) {
    const Vec3<double> n = cross(at(t.v[1]) - at(t.v[0]), at(t.v[2]) - at(t.v[0]));
    for (const Index v : t.v) normals[static_cast<std::size_t>(v)] += n;
  }
  return normals;
}

/// Draws the triangles of a mesh that are wholly in front of the camera's near plane.
/// @param part 1 cloth, 2 obstacle
inline void draw(Raster& picture, const ViewCamera& camera, const Mesh& mesh, unsigned char part) {
  const std::vector<Vec3<double>> normals = summed_normals(mesh);
  for (const Tri& t : mesh.triangles) {
    Vec3<double> seen[3];
    Vec2<double> p[3];
    double facing[3];
    bool behind = false;
    for (int j = 0; j < 3; ++j) {
      const auto v = static_cast<std::size_t>(t.v[j]);
      seen[j] = camera.seen(mesh.positions[v]);
      behind = behind || !(seen[j][2] > camera.near());
      p[j] = camera.pixel(seen[j]);
      const Vec3<double> way = mesh.positions[v] - camera.eye();
      const double scale = length(way) * length(normals[v]);
      facing[j] = scale > 0 ? dot(way, normals[v]) / scale : 0;
    }
    const Vec2<double> a = p[1] - p[0], b = p[2] - p[0];
    const double det = a[0] * b[1] - a[1] * b[0];
    if (behind || det == 0 || !std::isfinite(det)) continue;
    const auto bound = [&](int axis, bool high, int count) {
      const double value = high ? std::max({p[0][axis], p[1][axis], p[2][axis]})
                                : std::min({p[0][axis], p[1][axis], p[2][axis]});
      return static_cast<int>(std::clamp(std::ceil(value - 0.5), 0.0, 1.0 * count));
    };
    for (int y = bound(1, false, picture.height); y < bound(1, true, picture.height); ++y)
      for (int x = bound(0, false, picture.width); x < bound(0, true, picture.width); ++x) {
        const Vec2<double> d = Vec2<double>{x + 0.5, y + 0.5} - p[0];
        const double u = (d[0] * b[1] - d[1] * b[0]) / det;
        const double v = (a[0] * d[1] - a[1] * d[0]) / det;
        if (u < 0 || v < 0 || u + v > 1) continue;
        const double near = (1 - u - v) / seen[0][2] + u / seen[1][2] + v / seen[2][2];
        const std::size_t i = picture.at(x, y);
        if (!(1 / near < picture.depth[i])) continue;
        picture.depth[i] = static_cast<float>(1 / near);
        picture.part[i] = part;
        picture.shade[i] =
            static_cast<float>(std::abs((1 - u - v) * facing[0] + u * facing[1] + v * facing[2]));
      }
  }
}

/// The cloths and what hides them.
inline Raster picture_of(const ViewCamera& camera, const Mesh& cloths, const Mesh& obstacles) {
  Raster picture;
  picture.width = camera.width();
  picture.height = camera.height();
  const std::size_t count = picture.at(0, picture.height);
  picture.depth.assign(count, std::numeric_limits<float>::infinity());
  picture.part.assign(count, 0);
  picture.shade.assign(count, 0);
  draw(picture, camera, cloths, 1);
  draw(picture, camera, obstacles, 2);
  return picture;
}

/// Pixels of cloth beside others: the silhouette. Where the picture ends is none.
inline std::vector<unsigned char> silhouette(const Raster& picture) {
  std::vector<unsigned char> edge(picture.part.size(), 0);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      if (picture.part[picture.at(x, y)] != 1) continue;
      const auto differs = [&](int i, int j) {
        return i >= 0 && j >= 0 && i < picture.width && j < picture.height &&
               picture.part[picture.at(i, j)] != 1;
      };
      edge[picture.at(x, y)] =
          differs(x - 1, y) || differs(x + 1, y) || differs(x, y - 1) || differs(x, y + 1);
    }
  return edge;
}

/// Distance of every pixel from the nearest marked one, exact; infinity if there is none. [pixels]
inline std::vector<double> distances_from(const std::vector<unsigned char>& marked, int width,
                                          int height) {
  const double far = std::numeric_limits<double>::infinity();
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  };
  // Down the columns first: rows to the nearest mark of the own column.
  std::vector<double> rows(marked.size(), far);
  for (int x = 0; x < width; ++x) {
    double last = far;
    for (int y = 0; y < height; ++y) rows[at(x, y)] = last = marked[at(x, y)] != 0 ? 0 : last + 1;
    last = far;
    for (int y = height - 1; y >= 0; --y)
      rows[at(x, y)] = last = std::min(rows[at(x, y)], last + 1);
  }
  std::vector<double> result(marked.size(), far);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double least = rows[at(x, y)] * rows[at(x, y)];
      for (int away = 1; 1.0 * away * away < least && away < width; ++away)
        for (const int i : {x - away, x + away})
          if (i >= 0 && i < width)
            least = std::min(least, 1.0 * away * away + rows[at(i, y)] * rows[at(i, y)]);
      result[at(x, y)] = std::sqrt(least);
    }
  return result;
}

/// How a picture differs from another one of the same camera.
struct PictureError {
  double silhouette_mean = 0;  ///< [pixels] from a silhouette's pixel to the other silhouette
  double silhouette_p95 = 0;   ///< [pixels] of these, 95 % are nearer
  double shade_rms = 0;        ///< of pixels that show cloth in both
  double shade_share = 0;      ///< of these, how many differ by more than a tenth
  bool any = false;            ///< both have a silhouette
};

inline PictureError picture_error(const Raster& reference, const Raster& picture) {
  PictureError error;
  const std::vector<unsigned char> edges[2] = {silhouette(reference), silhouette(picture)};
  std::vector<double> ways;
  for (int k = 0; k < 2; ++k) {
    if (std::find(edges[1 - k].begin(), edges[1 - k].end(), 1) == edges[1 - k].end()) return error;
    const std::vector<double> far = distances_from(edges[1 - k], reference.width, reference.height);
    for (std::size_t i = 0; i < far.size(); ++i)
      if (edges[k][i] != 0) ways.push_back(far[i]);
  }
  if (ways.empty()) return error;
  error.any = true;
  for (const double way : ways) error.silhouette_mean += way / static_cast<double>(ways.size());
  std::sort(ways.begin(), ways.end());
  error.silhouette_p95 = ways[ways.size() * 95 / 100];
  double both = 0, squares = 0, beyond = 0;
  for (std::size_t i = 0; i < reference.part.size(); ++i) {
    if (reference.part[i] != 1 || picture.part[i] != 1) continue;
    const double difference = std::abs(1.0 * reference.shade[i] - picture.shade[i]);
    both += 1;
    squares += difference * difference;
    if (difference > 0.1) beyond += 1;
  }
  if (both > 0) {
    error.shade_rms = std::sqrt(squares / both);
    error.shade_share = beyond / both;
  }
  return error;
}

}  // namespace weft::bench
